// ArcStar: corner detection by the length of the newest arc on two circles around the event, for
// events that pass the ArcFilter. On the circle of 16 pixels the arc has at most 6 or 10 to 13 of
// them, on the one of 20 at most 8 or 12 to 16. Threads, cost and allocation: corner_detector.hpp.
// Source: Alzugaray, Chli, "Asynchronous Corner Detection and Tracking for Event Cameras in Real
// Time", RA-L 2018; the length is the one of its release (arc_length.hpp).
#pragma once

#include <cstdint>

#include "asap/algorithms/arc_filter.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/order_surface.hpp"

namespace asap {

struct ArcStarConfig {
  int width;                       // px
  int height;                      // px
  std::int64_t filter_us = 50000;  // window of the ArcFilter
};

class ArcStarRule {
 public:
  using Config = ArcStarConfig;

  explicit ArcStarRule(const Config& config);

  bool is_corner(const Event& event) noexcept;
  void clear() noexcept;
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  SensorFrame frame_;
  ArcFilter filter_;
  OrderSurface surface_;  // of the events that passed
};

extern template class CornerDetector<ArcStarRule>;
using ArcStar = CornerDetector<ArcStarRule>;

}  // namespace asap
