// SpeedInvariantTimeSurface (SITS): the order in which the pixels of a neighbourhood fired, as
// ranks from (2 radius + 1)^2, the newest, down to 0, independent of speed. An event takes 1 from
// every pixel of the window around it that ranks above its own, and sets its own to the top.
// Threads, cost and allocation: event_surface.hpp.
// Source: Manderscheid, Sironi, Bourdis, Migliore, Lepetit, "Speed Invariant Time Surface for
// Learning to Detect Corner Points with Event-Based Cameras", CVPR 2019, algorithm 1, with one
// surface for both polarities.
#pragma once

#include <cstdint>
#include <vector>

#include "asap/algorithms/event_surface.hpp"
#include "asap/algorithms/padded_plane.hpp"
#include "asap/algorithms/sensor_frame.hpp"

namespace asap {

struct SpeedInvariantTimeSurfaceConfig {
  int width;       // px
  int height;      // px
  int radius = 6;  // px; the window is 2 radius + 1 wide
};

class SpeedInvariantTimeRule {
 public:
  using Config = SpeedInvariantTimeSurfaceConfig;
  using Value = std::uint16_t;

  explicit SpeedInvariantTimeRule(const Config& config);

  void update(const Event& event) noexcept;
  PaddedPlane<Value>& plane() noexcept { return plane_; }
  const PaddedPlane<Value>& plane() const noexcept { return plane_; }
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  int side_;
  SensorFrame frame_;
  PaddedPlane<Value> plane_;
  std::vector<Value> beyond_;  // per column of the blocks: all bits set beyond the window, else 0
};

extern template class EventSurface<SpeedInvariantTimeRule>;
using SpeedInvariantTimeSurface = EventSurface<SpeedInvariantTimeRule>;

}  // namespace asap
