// OrderSurface: a surface of active events that keeps the order instead of the time: per pixel and
// polarity the number of the latest event, or of its timestamp. Four bytes, whatever the
// timestamps, and as good for every rule that only compares. A border of kPad pixels that never
// fire lies around the frame. One thread. O(1) per event and no allocation after construction.
// After 2^31 numbers the pixels are renumbered, which keeps their order exactly: one sort of them
// all.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "algorithms/sensor_frame.hpp"
#include "asap/core/event.hpp"
#include "core/event_clock.hpp"

namespace asap::inline v0_1 {

class OrderSurface {
 public:
  using Number = std::int32_t;
  static constexpr Number kNever = 0;
  static constexpr std::uint32_t kPad = 4;

  // Numbers stay below `limit`, which is larger than the number of pixels.
  explicit OrderSurface(const SensorFrame& frame,
                        Number limit = std::numeric_limits<Number>::max());

  // The pixel under an event of the frame, on the plane of its polarity. Rows are stride() apart.
  Number* pixel(const Event& event) noexcept {
    const std::size_t plane = event.p > 0 ? plane_ : 0;
    return numbers_.data() + plane + (event.y + kPad) * stride_ + event.x + kPad;
  }
  std::ptrdiff_t stride() const noexcept { return static_cast<std::ptrdiff_t>(stride_); }

  // Number of the next event: larger than all.
  Number next() noexcept {
    if (newest_ >= limit_ - 1) [[unlikely]]
      renumber();
    return ++newest_;
  }

  // Number of a timestamp: equal timestamps, equal numbers. A timestamp that goes back counts as
  // EventClock says. One surface numbers either events or timestamps.
  Number next(std::int64_t stamp_us) noexcept {
    if (stamp_us <= last_us_) {
      if (begins_epoch(last_us_, stamp_us)) last_us_ = stamp_us;
      return newest_;
    }
    last_us_ = stamp_us;
    return next();
  }

  void clear() noexcept;

 private:
  static constexpr Number kFirst = kNever + 1;

  void renumber() noexcept;

  std::size_t stride_;
  std::size_t plane_;
  Number limit_;
  Number newest_ = kFirst;
  std::int64_t last_us_ = std::numeric_limits<std::int64_t>::min();
  std::vector<Number> numbers_;
  std::unique_ptr<Number[]>
      scratch_;  // renumber() uses it; untouched, and so not resident, until then
};

inline OrderSurface::OrderSurface(const SensorFrame& frame, Number limit)
    : stride_(frame.width() + 2 * kPad),
      plane_(stride_ * (frame.height() + 2 * kPad)),
      limit_(limit),
      numbers_(2 * plane_, kNever),
      scratch_(std::make_unique_for_overwrite<Number[]>(2 * plane_)) {}

inline void OrderSurface::clear() noexcept {
  std::fill(numbers_.begin(), numbers_.end(), kNever);
  newest_ = kFirst;
  last_us_ = std::numeric_limits<std::int64_t>::min();
}

inline void OrderSurface::renumber() noexcept {
  Number* const first = scratch_.get();
  Number* const last = std::remove_copy(numbers_.begin(), numbers_.end(), first, kNever);
  std::sort(first, last);
  for (Number& number : numbers_) {
    if (number == kNever) continue;
    number = kFirst + static_cast<Number>(std::lower_bound(first, last, number) - first);
  }
  newest_ = kFirst + static_cast<Number>(last - first);
}

}  // namespace asap::inline v0_1
