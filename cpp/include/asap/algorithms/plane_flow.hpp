// PlaneFlow: optical flow of each event, normal to its edge. The times at which the pixels of the
// 5 x 5 window fired last, in the event's polarity and within a window of time, lie near a plane;
// its slope is the inverse of the edge's velocity. After a first fit the points far from the plane
// are dropped, once. One thread. O(1) per event; no allocation after construction.
// Source: Benosman, Clercq, Lagorce, Ieng, Bartolozzi, "Event-Based Visual Flow", IEEE TNNLS 2014.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "asap/algorithms/plane_fit.hpp"
#include "asap/algorithms/recent_times.hpp"
#include "asap/algorithms/sensor_frame.hpp"
#include "asap/core/event.hpp"

namespace asap {

// NaN where the events around give no flow: too few, all on a line, or all at once.
struct Flow {
  float vx = std::numeric_limits<float>::quiet_NaN();  // px/s, to the right
  float vy = std::numeric_limits<float>::quiet_NaN();  // px/s, downwards
};

struct PlaneFlowConfig {
  int width;                       // px
  int height;                      // px
  std::int64_t window_us = 25000;  // older events do not count
  int min_points = 5;              // pixels of the window, the event's own included
  bool refit = true;               // without the points far from the first plane
};

class PlaneFlow {
 public:
  using Config = PlaneFlowConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit PlaneFlow(const Config& config);

  // Returns how many of the events have a flow. Events outside the frame are dropped and counted.
  std::size_t process(EventSpan events) noexcept;

  // As above, and flows[i] is that of events[i]. Throws std::invalid_argument if the sizes differ.
  std::size_t process(EventSpan events, std::span<Flow> flows);

  // The fraction of the events that reaches the algorithm, in [0, 1]. Checked, without effect: a
  // window grown by 1 / gamma reaches back to edges that passed before, and under noise the flow of
  // one event in two points elsewhere (measured at gamma 0.2).
  void set_keep(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  bool update(const Event& event, Flow& flow) noexcept;

  Config config_;
  SensorFrame frame_;
  std::size_t stride_;
  std::size_t plane_;
  RecentTimes times_;  // a plane per polarity; a border lies around the frame
  std::uint64_t rejected_ = 0;
};

}  // namespace asap
