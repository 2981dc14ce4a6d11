// EveryEvent: the detector that takes every event of the frame for a corner, for streams that hold
// corners alone. Threads, cost and allocation: corner_detector.hpp.
#pragma once

#include "asap/algorithms/corner_detector.hpp"

namespace asap {

struct EveryEventConfig {
  int width;   // px
  int height;  // px
};

class EveryEventRule {
 public:
  using Config = EveryEventConfig;

  explicit EveryEventRule(const Config& config) : frame_(config.width, config.height) {}

  bool is_corner(const Event&) noexcept { return true; }
  void clear() noexcept {}
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  SensorFrame frame_;
};

using EveryEvent = CornerDetector<EveryEventRule>;

}  // namespace asap
