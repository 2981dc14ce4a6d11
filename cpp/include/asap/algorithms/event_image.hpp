// EventImage: images of the events, one per so many events or per period of the sensor's clock, in
// channels of float: what convolutional networks take. One thread. O(1) per event; a complete image
// costs one pass over the pixels. No allocation after construction.
//
// An image by count ends with its last event; one by period holds the timestamps from one multiple
// of the period to the next, and a period without events gives no image. Behind a discarder every
// event stands for 1 / gamma: images end as often as without it, and hold as much on average.
// Source of the channels: Sanket et al., "EVDodgeNet", ICRA 2020; Zhu et al., "EV-FlowNet", RSS
// 2018.
//
//   EventImage image{{.width = 346, .height = 260, .count = 10'000}};
//   image.process(events, [](const ImageView& view) { show(view.values); });
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

enum class ImageChannel : std::uint8_t {
  off,    // OFF events of the pixel
  on,     // ON events
  count,  // both
  sum,    // ON minus OFF
  time    // the latest event, from 0 = begin to 1 = end of the image; 0 without one
};

struct EventImageConfig {
  int width;                           // px
  int height;                          // px
  std::int64_t count = 0;              // events of an image; or
  std::chrono::microseconds period{};  // its duration. One of the two is 0
  std::vector<ImageChannel> channels{ImageChannel::off, ImageChannel::on};
};

struct ImageView {
  std::span<const float> values;  // channel, row, column; valid until the next image
  std::int64_t begin_us;          // the first timestamp of an image by count
  std::int64_t end_us;            // first timestamp beyond; by count: 1 after the last
};

class EventImage {
 public:
  using Config = EventImageConfig;
  static constexpr double kMinGamma = 1e-3;  // below it, events count as at it

  // Throws std::invalid_argument that names the bad field.
  explicit EventImage(const Config& config);
  ~EventImage();
  EventImage(const EventImage& other);
  EventImage& operator=(const EventImage& other);
  EventImage(EventImage&& other) noexcept;
  EventImage& operator=(EventImage&& other) noexcept;

  // Calls on_image(ImageView) for each image that these events complete, and returns their number.
  // Events outside the frame are dropped and counted. A timestamp that goes back by at most a
  // second counts as the latest one; a larger step back ends an image by period.
  template <class OnImage>
  std::size_t process(EventSpan events, OnImage&& on_image) {
    std::size_t complete = 0;
    while (take(events)) {
      ++complete;
      on_image(image());
    }
    return complete;
  }

  // Takes the events; the last complete image is left in image().
  std::size_t process(EventSpan events) noexcept {
    return process(events, [](const ImageView&) {});
  }

  // Completes the image that has begun. False if none has.
  bool flush() noexcept;

  // The last complete image; zeros before the first.
  ImageView image() const noexcept;

  // Tells the share of the next events that thinning kept, in [0, 1]; see above.
  void set_gamma(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  // Takes events from the front of `events` until one of them completes an image. False: all are
  // taken and none did.
  bool take(EventSpan& events) noexcept;

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
