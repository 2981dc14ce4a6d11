// CompatClusterTracker: finds the moving objects in a stream of events, event by event, with the
// results of the published clustering (CompatClusterConfig: its parameters and their source). Each
// cluster has an id, centroid, covariance and velocity. One thread at a time. process() is O(1) per
// event, whatever the number of clusters, and allocates nothing; all memory is taken in the
// constructor. The velocity is the regression of x and y on t over the live events, exact
// arithmetic but a rough estimate where the window lasts only milliseconds, or of a Kalman filter
// (Config::motion).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "asap/algorithms/cluster.hpp"
#include "asap/algorithms/compat_cluster_config.hpp"
#include "asap/core/event.hpp"

namespace asap {

class CompatClusterTracker {
 public:
  using Config = CompatClusterConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit CompatClusterTracker(const Config& config);
  ~CompatClusterTracker();
  CompatClusterTracker(CompatClusterTracker&& other) noexcept;
  CompatClusterTracker& operator=(CompatClusterTracker&& other) noexcept;

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // As above, and labels[i] is the id of the cluster that took events[i]: -1 where it has none yet,
  // for want of min_size events, and for dropped events. Throws std::invalid_argument if the sizes
  // differ.
  void process(EventSpan events, std::span<std::int32_t> labels);

  // The clusters of at least min_size events, sorted by id.
  std::vector<Cluster> clusters() const;

  // The same without allocation once `clusters` has the capacity.
  void clusters(std::vector<Cluster>& clusters) const;

  // The same with positions predicted for t_us, by a filter that looks up to 0.1 s ahead; else
  // `clusters`: events alone make the rule forget. A t_us of the past is the latest time.
  std::vector<Cluster> clusters_at(std::int64_t t_us) const;
  void clusters_at(std::int64_t t_us, std::vector<Cluster>& clusters) const;

  // The fraction of the events that reaches the tracker, in [0, 1]. Checked, without effect: the
  // published rule does not know it, its window of S events stretches in time by itself.
  void set_keep(double gamma);

  // Back to the state after construction, seed included: the same events give the same results.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

}  // namespace asap
