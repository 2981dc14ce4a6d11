// PlaneFlow: optical flow of each event, normal to its edge. The times at which the pixels around
// fired lie near a plane, in the event's polarity and within a window of time; its slope is the
// inverse of the edge's velocity. An edge fires several events per pixel: only the first tells when
// it came, so those that follow another one at their pixel within a quarter of the window (10 ms)
// have no flow and enter no fit. Nor has an event whose neighbours are not one edge. Edges must
// cover some 3 px in the window. One thread. O(1) per event; no allocation after construction.
// Source: Benosman, Clercq, Lagorce, Ieng, Bartolozzi, "Event-Based Visual Flow", IEEE TNNLS 2014,
// which takes every event and every plane: `refit`.
//
//   PlaneFlow flow{{.width = 346, .height = 260}};
//   std::vector<Flow> flows(events.size());
//   flow.process(events, std::span(flows));  // px/s; NaN where the events around give none
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

// NaN where the events around give no flow: too few, all on a line, all at once or not one edge.
struct Flow {
  float vx = std::numeric_limits<float>::quiet_NaN();  // px/s, to the right
  float vy = std::numeric_limits<float>::quiet_NaN();  // px/s, downwards
};

struct PlaneFlowConfig {
  int width;                                // px
  int height;                               // px
  std::chrono::microseconds window{40000};  // older events do not count
  int min_points = 7;                       // pixels of a fit, the event's own included
  // Not set: the first events of an edge, 7 x 7 px, a fit that is tested. Set: the published rule,
  // every event and 5 x 5 px, with (true) or without a second fit that leaves the outliers out.
  std::optional<bool> refit{};
};

class PlaneFlow {
 public:
  using Config = PlaneFlowConfig;
  using Answer = Flow;

  // Rows around an event that its flow depends on.
  static constexpr int reach(const Config&) noexcept { return 3; }

  // Throws std::invalid_argument that names the bad field.
  explicit PlaneFlow(const Config& config);
  ~PlaneFlow();
  PlaneFlow(const PlaneFlow& other);
  PlaneFlow& operator=(const PlaneFlow& other);
  PlaneFlow(PlaneFlow&& other) noexcept;
  PlaneFlow& operator=(PlaneFlow&& other) noexcept;

  // Returns how many of the events have a flow. Events outside the frame are dropped and counted.
  std::size_t process(EventSpan events) noexcept;

  // Takes the events, and flows[i] is that of events[i]. Throws std::invalid_argument if the sizes
  // differ.
  std::size_t process(EventSpan events, std::span<Flow> flows);
  // As Tiled deals them: flows[places[i]] is that of events[i], if there is such a place.
  void process(EventSpan events, std::span<Flow> flows, const std::uint32_t* places) noexcept;

  // The fraction of the events that reaches the algorithm, in [0, 1]. Checked, without effect: none
  // is needed, and a window grown by 1 / gamma reaches back to edges that passed before.
  void set_gamma(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
