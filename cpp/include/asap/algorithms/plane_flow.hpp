// PlaneFlow: optical flow of each event, normal to its edge. The times at which the pixels of the
// 5 x 5 window fired last, in the event's polarity and within a window of time, lie near a plane;
// its slope is the inverse of the edge's velocity. After a first fit the points far from the plane
// are dropped, once. One thread. O(1) per event; no allocation after construction.
// Source: Benosman, Clercq, Lagorce, Ieng, Bartolozzi, "Event-Based Visual Flow", IEEE TNNLS 2014.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

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
  ~PlaneFlow();
  PlaneFlow(const PlaneFlow& other);
  PlaneFlow& operator=(const PlaneFlow& other);
  PlaneFlow(PlaneFlow&& other) noexcept;
  PlaneFlow& operator=(PlaneFlow&& other) noexcept;

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
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace asap
