// ThresholdOrdinalSurface (TOS): how recently each pixel fired, counted in events of its
// neighbourhood, in 8 bits. An event takes 1 from every pixel of the side x side window around it,
// to 0 what thereby falls below 255 - 2 side, and sets its own to 255. So the surface shows edges
// with the same width at any speed. Threads, cost and allocation: event_surface.hpp.
// Source: Glover, Dinale, De Souza Rosa, Bamford, Bartolozzi, "luvHarris: A Practical Corner
// Detector for Event-Cameras", TPAMI 2021. Public releases clear from one value lower.
#pragma once

#include <cstdint>
#include <vector>

#include "asap/algorithms/event_surface.hpp"
#include "asap/algorithms/padded_plane.hpp"
#include "asap/algorithms/sensor_frame.hpp"

namespace asap {

struct ThresholdOrdinalSurfaceConfig {
  int width;     // px
  int height;    // px
  int side = 7;  // px of the window, odd
};

class ThresholdOrdinalRule {
 public:
  using Config = ThresholdOrdinalSurfaceConfig;
  using Value = std::uint8_t;

  explicit ThresholdOrdinalRule(const Config& config);

  void update(const Event& event) noexcept;
  PaddedPlane<Value>& plane() noexcept { return plane_; }
  const PaddedPlane<Value>& plane() const noexcept { return plane_; }
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  int side_;
  SensorFrame frame_;
  PaddedPlane<Value> plane_;
  // Per column of the blocks: what an event takes away, and the largest value that it clears. 0 and
  // 0, which change nothing, beyond the window.
  std::vector<Value> steps_;
  std::vector<Value> bars_;
};

extern template class EventSurface<ThresholdOrdinalRule>;
using ThresholdOrdinalSurface = EventSurface<ThresholdOrdinalRule>;

}  // namespace asap
