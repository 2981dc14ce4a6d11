// EventImage: images of the events, one per so many events or per period of the sensor's clock, in
// channels of float: what convolutional networks take. One thread. O(1) per event; a complete image
// costs one pass over the pixels. No allocation after construction.
//
// By count an image ends with its last event; by period it holds the stamps from one multiple of
// the period to the next, and a period without events gives no image. Behind a discarder every
// event stands for 1 / gamma: images end as often as without it, and hold as much on average.
// Source of the channels: Sanket et al., "EVDodgeNet", ICRA 2020; Zhu et al., "EV-FlowNet", RSS
// 2018.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "asap/algorithms/sensor_frame.hpp"
#include "asap/core/event.hpp"

namespace asap {

enum class ImageChannel : std::uint8_t {
  off,    // OFF events of the pixel
  on,     // ON events
  count,  // both
  sum,    // ON minus OFF
  time    // of the latest event, from 0 = begin to 1 = end of the image; 0 without one
};

struct EventImageConfig {
  int width;                   // px
  int height;                  // px
  std::int64_t count = 0;      // events of an image; or
  std::int64_t period_us = 0;  // its duration. One of the two is 0
  std::vector<ImageChannel> channels{ImageChannel::off, ImageChannel::on};
};

struct ImageView {
  std::span<const float> values;  // by channel, row, column; valid until the next image
  std::int64_t begin_us;          // by count: the first stamp
  std::int64_t end_us;            // first stamp beyond; by count: 1 after the last
};

class EventImage {
 public:
  using Config = EventImageConfig;
  static constexpr double kLeastKeep = 1e-3;  // below it, events count as at it

  // Throws std::invalid_argument that names the bad field.
  explicit EventImage(const Config& config);

  // Calls on_image(ImageView) for each image that these events complete, and returns their number.
  // Events outside the frame are dropped and counted. Stamps that go back count as the latest one.
  template <class OnImage>
  std::size_t process(EventSpan events, OnImage&& on_image) {
    std::size_t complete = 0;
    const auto close_image = [&] {
      close();
      ++complete;
      on_image(image());
    };
    for (const Event& event : events) {
      if (!frame_.contains(event)) [[unlikely]] {
        ++rejected_;
        continue;
      }
      last_us_ = event.t > last_us_ ? event.t : last_us_;
      if (period_is_over()) close_image();
      add(event);
      if (is_full()) close_image();
    }
    return complete;
  }

  // As above; the last complete image is left in image().
  std::size_t process(EventSpan events) noexcept {
    return process(events, [](const ImageView&) {});
  }

  // Completes the image that has begun. False if none has.
  bool flush() noexcept;

  // The last complete image; zeros before the first.
  ImageView image() const noexcept { return {image_, image_begin_us_, image_end_us_}; }

  // The fraction of the events that reaches the images, in [0, 1]; see above.
  void set_keep(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  // later - earlier, without overflow.
  static std::uint64_t distance(std::int64_t earlier, std::int64_t later) noexcept {
    return static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier);
  }

  bool has_begun() const noexcept { return filled_ > 0; }
  bool period_is_over() const noexcept {
    return config_.period_us > 0 && has_begun() &&
           distance(begin_us_, last_us_) >= static_cast<std::uint64_t>(config_.period_us);
  }
  bool is_full() const noexcept {
    return config_.count > 0 && filled_ >= static_cast<double>(config_.count);
  }

  void begin() noexcept;
  void close() noexcept;
  void draw(ImageChannel channel, float* out) const noexcept;

  void add(const Event& event) noexcept {
    if (!has_begun()) begin();
    const std::size_t pixel = event.y * std::size_t{frame_.width()} + event.x;
    (event.p > 0 ? on_ : off_)[pixel] += static_cast<float>(weight_);
    times_us_[pixel] = last_us_;
    filled_ += weight_;
  }

  Config config_;
  SensorFrame frame_;
  std::vector<float> off_;  // of the image that has begun
  std::vector<float> on_;
  std::vector<std::int64_t> times_us_;
  std::vector<float> image_;
  double weight_ = 1;
  double filled_ = 0;  // weight of the image that has begun
  std::int64_t begin_us_ = 0;
  std::int64_t last_us_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t image_begin_us_ = 0;
  std::int64_t image_end_us_ = 0;
  std::uint64_t rejected_ = 0;
};

}  // namespace asap
