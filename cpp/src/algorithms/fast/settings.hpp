// Settings: the configuration of ClusterTracker in the units of the engine (float, s, px, us), and
// what the kept fraction changes of it. Pure data; O(1), no allocation.
#pragma once

#include <cstdint>

#include "algorithms/fast/contact.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/kalman.hpp"
#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/mean_update.hpp"
#include "algorithms/fast/merge.hpp"
#include "algorithms/fast/pairs.hpp"
#include "asap/algorithms/cluster_tracker_config.hpp"

namespace asap::fast {

struct Settings {
  // Precondition: the configuration is checked.
  explicit Settings(const ClusterTrackerConfig& config) noexcept;

  // Random discarding leaves gamma of the events: the mean remembers fewer, the contour learns from
  // more of them, neighbours are as rare, so company counts for longer, and fewer events make a
  // cluster. `filtered_upstream`: a filter before the discarder has judged them already, so from
  // 0.15 to 0.75 none is rejected; below none is anyway. gamma = 1 changes nothing.
  void set_keep(const ClusterTrackerConfig& config, double gamma, bool filtered_upstream) noexcept;

  // Recent events without a cluster around a cell that noise alone stays below.
  float birth_threshold(float noise_hz) const noexcept;

  std::int32_t tick_us;
  std::int32_t warmup_us;
  std::int32_t link_us;
  std::int32_t support_window_us;
  float seed_s;
  float seed_events;
  float cell_px;
  bool asks_support;
  bool rejects;
  UpdateRule update;
  WeightRule weight;
  ContactRule contact;
  GateRule gate;
  KalmanRule kalman;
  LifeRule life;
  PairRule pairs;
  MergeRule merge;
};

}  // namespace asap::fast
