// FAHarris: corner detection in two steps: the arcs of Arc* propose, the Harris score of the 25
// newest pixels decides. Both look only at events that pass the ArcFilter, of the event's polarity.
// Events within 4 px of the border are ignored altogether. Threads, cost and allocation:
// corner_detector.hpp.
// Source: Li, Shi, Zhang, Li, Liu, "FA-Harris: A Fast and Asynchronous Corner Detector for Event
// Cameras", IROS 2019, with the constants of its release; equal stamps are ordered by arrival.
#pragma once

#include <cstdint>

#include "asap/algorithms/arc_filter.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/newest_patch.hpp"
#include "asap/algorithms/order_surface.hpp"

namespace asap {

struct FAHarrisConfig {
  int width;                       // px
  int height;                      // px
  std::int64_t filter_us = 50000;  // window of the ArcFilter
  double threshold = 8;            // of the score
};

class FAHarrisRule {
 public:
  using Config = FAHarrisConfig;

  explicit FAHarrisRule(const Config& config);

  bool is_corner(const Event& event) noexcept;
  void clear() noexcept;
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  SensorFrame frame_;
  double threshold_;
  ArcFilter filter_;
  OrderSurface stamps_;    // of the events that passed: for the arcs, where equal stamps are ties
  OrderSurface arrivals_;  // of the same events: for the patch, which has no ties
  NewestPatch patch_;
};

extern template class CornerDetector<FAHarrisRule>;
using FAHarris = CornerDetector<FAHarrisRule>;

}  // namespace asap
