// ClusterTracker: detects and tracks the moving objects in an event stream, event by event, with
// one setting for objects of radius 3 to 20 px. Each has an id, position, velocity and covariance.
// It needs no noise filter in front; set_keep() tells it the kept fraction. One thread at a time.
// process() is O(1) per event, whatever the number of clusters, and allocates nothing: the
// constructor takes all memory. Results do not depend on how the stream is cut into calls. A
// timestamp that goes back by at most a second counts as the latest one; after a larger step back
// time goes on from there.
// Source: own design (fast/engine.hpp); PublishedClusterTracker is the published algorithm.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "asap/algorithms/cluster.hpp"
#include "asap/algorithms/cluster_tracker_config.hpp"
#include "asap/core/event.hpp"
#include "asap/core/result.hpp"

namespace asap {

class ClusterTracker {
 public:
  using Config = ClusterTrackerConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit ClusterTracker(const Config& config);
  ~ClusterTracker();
  ClusterTracker(ClusterTracker&& other) noexcept;
  ClusterTracker& operator=(ClusterTracker&& other) noexcept;

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // As above, and labels[i] is the id of the cluster that took events[i]: -1 for noise, for a
  // cluster that is not confirmed yet, and for dropped events. Throws std::invalid_argument if the
  // sizes differ.
  void process(EventSpan events, std::span<std::int32_t> labels);

  // The confirmed clusters at the latest time, sorted by id, positions predicted for that time.
  // A cluster whose object has stopped or is occluded is not listed, but keeps its id for a while.
  // `size` counts recent events.
  std::vector<Cluster> clusters() const;

  // The same without allocation once `clusters` has the capacity.
  void clusters(std::vector<Cluster>& clusters) const;

  // What `clusters` would be at t_us if no event came until then. The tracker does not change, and
  // events before t_us may follow. A t_us of the past counts as the latest time.
  std::vector<Cluster> clusters_at(std::int64_t t_us) const;
  void clusters_at(std::int64_t t_us, std::vector<Cluster>& clusters) const;

  // The outline of the cluster with this id. Empty: `clusters` does not list it.
  std::optional<ClusterOutline> outline(std::int64_t id) const;

  // Advances the time to t_us when it is known that no event came: clusters stop, coast and are
  // deleted. Later events with older timestamps count as of t_us. Does nothing before the first
  // event and for a t_us of the past. To look ahead, use clusters_at().
  void advance_to(std::int64_t t_us) noexcept;

  // Sets the fraction of the events that reaches the tracker, in [0, 1]; its memories, which count
  // events, adapt. Cheap enough for every package. `filter_upstream`: a noise filter stands before
  // the thinning. Throws std::invalid_argument if gamma is out of range.
  void set_keep(double gamma, bool filter_upstream = false);

  // Back to the state after construction: the same events give the same results.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  // Events without support, that is without a recent event among their neighbours: mostly noise.
  std::uint64_t unsupported() const noexcept;

  // Clusters that did not begin because the table was full.
  std::uint64_t refused() const noexcept;

  const Config& config() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

// The same, for a program without exceptions; or a PublishedClusterTracker:
// make_tracker<PublishedClusterTracker>({...}).
template <class Made = ClusterTracker>
Result<Made> make_tracker(const typename Made::Config& config) noexcept;

}  // namespace asap
