// EHarris: corner detection by the Harris score of the 25 pixels around an event that fired last,
// with its polarity. The event is a corner if the score of this set, as a black and white patch,
// exceeds the threshold. Threads, cost and allocation: corner_detector.hpp.
// Source: Vasco, Glover, Bartolozzi, "Fast Event-based Harris Corner Detection Exploiting the
// Advantages of Event-driven Cameras", IROS 2016, with the constants of the public implementation.
#pragma once

#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/newest_patch.hpp"
#include "asap/algorithms/order_surface.hpp"

namespace asap {

struct EHarrisConfig {
  int width;             // px
  int height;            // px
  double threshold = 8;  // of the score
};

class EHarrisRule {
 public:
  using Config = EHarrisConfig;

  explicit EHarrisRule(const Config& config);

  bool is_corner(const Event& event) noexcept;
  void clear() noexcept;
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  SensorFrame frame_;
  double threshold_;
  OrderSurface surface_;
  NewestPatch patch_;
};

extern template class CornerDetector<EHarrisRule>;
using EHarris = CornerDetector<EHarrisRule>;

}  // namespace asap
