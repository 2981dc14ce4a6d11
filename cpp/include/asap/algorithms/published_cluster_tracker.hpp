// PublishedClusterTracker: finds the moving objects in a stream of events, event by event, with the
// results of the published clustering. Each cluster has an id, centroid, covariance and velocity.
// One thread at a time. process() is O(1) per event, whatever the number of clusters, and allocates
// nothing; all memory is taken in the constructor. The velocity is the regression of x and y on t
// over the live events, exact arithmetic but a rough estimate where the window lasts only
// milliseconds.
// Source: Rodriguez-Gomez et al., "Asynchronous Event-Based Clustering and Tracking for Intrusion
// Monitoring in UAS", ICRA 2020. The defaults are the launch values of the authors' release.
//
//   PublishedClusterTracker tracker{{.width = 346, .height = 260}};
//   tracker.process(events);
//   for (const Cluster& cluster : tracker.clusters()) draw(cluster.id, cluster.x, cluster.y);
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

struct PublishedClusterTrackerConfig {  // [the paper's symbol]
  int width;                            // px
  int height;                           // px
  int window = 800;                     // [S] events that are remembered, over all clusters
  double radius = 20;                   // [R] px, L1 distance within which an event joins a cluster
  int probes = 1;          // [kappa] random live events of each cluster that are tried as well
  double weight = 0.9;     // [alpha] weight of the newest event in the centre
  int min_size = 15;       // [minN] events from which a cluster is reported, and probed beyond
  std::uint64_t seed = 0;  // seed of the probes
};

class PublishedClusterTracker {
 public:
  using Config = PublishedClusterTrackerConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit PublishedClusterTracker(const Config& config);
  ~PublishedClusterTracker();
  PublishedClusterTracker(PublishedClusterTracker&& other) noexcept;
  PublishedClusterTracker& operator=(PublishedClusterTracker&& other) noexcept;

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // Takes the events, and labels[i] is the id of the cluster that took events[i]: -1 where it has
  // none yet, for want of min_size events, and for dropped events. Throws std::invalid_argument if
  // the sizes differ.
  void process(EventSpan events, std::span<std::int32_t> labels);

  // The clusters of at least min_size events, sorted by id.
  std::vector<Cluster> clusters() const;

  // The same without allocation once `clusters` has the capacity.
  void clusters(std::vector<Cluster>& clusters) const;

  // `clusters` for any t_us: events alone make the rule forget.
  std::vector<Cluster> clusters_at(std::int64_t t_us) const;

  // The outline of the cluster with this id. Empty: `clusters` does not list it.
  std::optional<ClusterOutline> outline(std::int64_t id) const;

  // The fraction of the events that reaches the tracker, in [0, 1]. Checked, without effect: the
  // published rule does not know it, its window of S events stretches in time by itself.
  void set_gamma(double gamma);

  // Back to the state after construction, seed included: the same events give the same results.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
