// Settings: the configuration of ClusterTracker in the units of the engine (float, s, px, us), and
// how the kept fraction of the events changes it. One thread; O(1), no allocation.
#pragma once

#include <cstdint>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/update.hpp"
#include "asap/algorithms/cluster_tracker.hpp"

namespace asap::inline v0_1::fast {

struct Settings {
  // Precondition: the configuration is checked.
  explicit Settings(const ClusterTrackerConfig& config) noexcept;

  // Adapts to thinning, which leaves the fraction gamma of the events: the mean has a shorter
  // memory, the contour learns from a larger share of the events, the window of the support is
  // longer because neighbours are rarer, and fewer events make a cluster. gamma = 1 changes
  // nothing. `filtered_upstream`: a noise filter stands before the thinning, so events without
  // support are rejected from gamma = 0.75 instead of 0.08 on.
  void set_gamma(const ClusterTrackerConfig& config, double gamma, bool filtered_upstream) noexcept;

  // Upper bound on the recent unassociated events around a cell that noise alone explains.
  float birth_threshold(float noise_hz) const noexcept;

  std::int32_t support_window_us;
  std::int32_t longest_window_us;  // of the support, in little noise
  float seed_events;
  float dense_per_px;  // events per px of an extent: a track with fewer is not cut
  bool uses_support;
  bool rejects_unsupported;
  bool begins_unsupported;  // else such an event, where it is not rejected, begins no track
  UpdateRule update;
  GateRule gate;
  LifecycleRule lifecycle;
};

}  // namespace asap::inline v0_1::fast
