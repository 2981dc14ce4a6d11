// EFast: corner detection by order alone. An event is a corner if on a circle of 16 pixels around
// it 3 to 6 neighbouring ones fired later than all others, and 4 to 8 on a circle of 20; events of
// its polarity. Threads, cost and allocation: corner_detector.hpp.
// Source: Mueggler, Bartolozzi, Scaramuzza, "Fast Event-based Corner Detection", BMVC 2017. The
// authors' release swaps width and height of its surface; here they are as published.
#pragma once

#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/order_surface.hpp"

namespace asap {

struct EFastConfig {
  int width;   // px
  int height;  // px
};

class EFastRule {
 public:
  using Config = EFastConfig;

  explicit EFastRule(const Config& config);

  bool is_corner(const Event& event) noexcept;
  void clear() noexcept { surface_.clear(); }
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  SensorFrame frame_;
  OrderSurface surface_;
};

extern template class CornerDetector<EFastRule>;
using EFast = CornerDetector<EFastRule>;

}  // namespace asap
