// ClusterTracker: finds and follows the moving objects in a stream of events, event by event, with
// one setting for objects of radius 3 to 20 px; each has an id, position, velocity and covariance.
// It needs no filter in front and is told the kept fraction by set_keep. One thread at a time.
// process() is O(1) per event, whatever the number of clusters, and allocates nothing; all memory
// is taken in the constructor. Results do not depend on how the stream is cut into calls. A stamp
// that goes back counts as the latest one (by more than a second: time goes on from there).
// Source: own design (fast/engine.hpp); the published rule is PublishedClusterTracker.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "asap/algorithms/cluster.hpp"
#include "asap/algorithms/cluster_tracker_config.hpp"
#include "asap/core/event.hpp"

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

  // The confirmed clusters at the latest time, sorted by id, positions predicted for that time;
  // without those whose object has stopped or hides, which keep their id for a while. `size` counts
  // recent events.
  std::vector<Cluster> clusters() const;

  // The same without allocation once `clusters` has the capacity.
  void clusters(std::vector<Cluster>& clusters) const;

  // What `clusters` would be at t_us if nothing came until then. Asking changes nothing: events of
  // before t_us may follow. A t_us of the past is the latest time.
  std::vector<Cluster> clusters_at(std::int64_t t_us) const;
  void clusters_at(std::int64_t t_us, std::vector<Cluster>& clusters) const;

  // Time has come to t_us without events: clusters starve, coast and die. Later events with older
  // stamps count as of t_us. Before the first event, and for the past: nothing happens. For whoever
  // knows that no event came; to look ahead, clusters_at().
  void advance_to(std::int64_t t_us) noexcept;

  // The fraction of the events that reaches the tracker, in [0, 1]: its memories, which count
  // events, follow. Cheap; for every package. `filter_upstream`: a noise filter stands before the
  // discarder. Throws std::invalid_argument if gamma is out of range.
  void set_keep(double gamma, bool filter_upstream = false);

  // Back to the state after construction: the same events give the same results.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  // Events without a recent event among their neighbours: noise, as far as one can tell.
  std::uint64_t unsupported() const noexcept;

  // Clusters that were not begun because the table was full.
  std::uint64_t refused() const noexcept;

  const Config& config() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace asap
