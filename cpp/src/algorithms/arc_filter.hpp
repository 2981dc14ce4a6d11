// ArcFilter: lets the first event of an edge through and holds back the burst behind it: an event
// passes if the last one of its polarity at the pixel is older than window_us, or if the other
// polarity fired since. A quarter of the events pass. One thread. O(1) per event, no allocation
// after construction.
// Source: Alzugaray, Chli, "Asynchronous Corner Detection and Tracking for Event Cameras in Real
// Time", RA-L 2018; as in its release a pixel without an event counts as fired at time 0.
#pragma once

#include <cstddef>
#include <cstdint>

#include "algorithms/recent_times.hpp"
#include "algorithms/sensor_frame.hpp"
#include "asap/core/event.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

class ArcFilter {
 public:
  // Throws std::invalid_argument that names "filter_us", the field of the detectors that filter,
  // unless 0 <= window_us <= RecentTimes::kMaxWindow_us.
  ArcFilter(const SensorFrame& frame, std::int64_t window_us)
      : width_(frame.width()),
        window_us_(checked(window_us)),
        times_(2 * width_ * frame.height(), 0) {}

  // Precondition: the event lies in the frame.
  bool passes(const Event& event) noexcept {
    const RecentTimes::Time now = times_.time_of(event.t);
    RecentTimes::Time* pixel = times_.data() + 2 * (event.y * width_ + event.x);
    const std::size_t own = event.p > 0 ? 1 : 0;
    const RecentTimes::Time last = pixel[own];
    pixel[own] = now;
    return static_cast<int>(now - last > window_us_) | static_cast<int>(pixel[1 - own] > last);
  }

  // Takes the timestamp of an event that is not tested.
  void pass_over(const Event& event) noexcept { times_.time_of(event.t); }

  // The time of the latest event, passed over or not.
  std::int64_t now_us() const noexcept { return times_.now_us(); }

  void clear() noexcept { times_.clear(); }

 private:
  static RecentTimes::Time checked(std::int64_t window_us) {
    require(0 <= window_us && window_us <= RecentTimes::kMaxWindow_us, "filter_us", window_us,
            "must be 0 to 500000000 us");
    return static_cast<RecentTimes::Time>(window_us);
  }

  std::size_t width_;
  RecentTimes::Time window_us_;
  RecentTimes times_;  // OFF and ON of a pixel side by side
};

}  // namespace asap::inline v0_1
