// ClusterTracker: detects and tracks the moving objects in an event stream, event by event, with
// one setting for objects of radius 3 to 20 px. Each has an id, position, velocity and covariance.
// It needs no noise filter in front; set_gamma() tells it the kept fraction. One thread at a time.
// process() is O(1) per event, whatever the number of clusters, and allocates nothing: the
// constructor takes all memory. Results do not depend on how the stream is cut into calls. A
// timestamp that goes back by at most a second counts as the latest one; after a larger step back
// time goes on from there.
// Source: own design; PublishedClusterTracker is the published algorithm.
//
//   ClusterTracker tracker{{.width = 346, .height = 260}};
//   tracker.process(events);
//   for (const Cluster& cluster : tracker.clusters()) draw(cluster.id, cluster.x, cluster.y);
#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/core/result.hpp"

namespace asap::inline v0_1 {

// ---- clusters ----------------------------------------------------------------------------------

// One object at the moment of the question. Plain data; the Python array of clusters has these
// fields in this order.
struct Cluster {
  std::int64_t id;      // never changes while the cluster lives
  double x;             // px, centroid
  double y;             // px
  double vx;            // px/s
  double vy;            // px/s
  double cxx;           // px^2, covariance of the events about the centroid
  double cxy;           // px^2
  double cyy;           // px^2
  std::int64_t size;    // live events
  std::int64_t t_last;  // us, timestamp of its newest event
  // px^2, covariance of the error of x and y; infinite: the tracker does not know it.
  double pxx = std::numeric_limits<double>::infinity();
  double pxy = 0;
  double pyy = std::numeric_limits<double>::infinity();
};

// One thing that an algorithm follows, at the moment of the question, made of one or more clusters.
// Plain data; the Python array of objects has these fields in this order.
struct TrackedObject {
  std::int64_t id;          // never changes, and outlives stops and short occlusions
  double x;                 // px, centre
  double y;                 // px
  double vx;                // px/s
  double vy;                // px/s
  double left;              // px, box
  double top;               // px
  double width;             // px
  double height;            // px
  std::int64_t size;        // live events
  std::int64_t t_last;      // us, timestamp of its newest event
  std::int64_t age_us;      // us, since it began
  double independent = -1;  // 0 to 1, whether it moves unlike the background; -1: not known
};

// The ellipse of two standard deviations of a cluster's events: that of a filled disk is its edge.
struct ClusterOutline {
  double x;      // px, centre
  double y;      // px
  double major;  // px, half-axis
  double minor;  // px, half-axis
  double angle;  // rad, of the major axis: from x (0) towards y, downwards; -pi/2 to pi/2
};

// Any thread; no allocation. Empty: no cluster has this id.
ClusterOutline outline_of(const Cluster& cluster) noexcept;
std::optional<ClusterOutline> outline_of(std::int64_t id,
                                         std::span<const Cluster> clusters) noexcept;

// ---- parameters --------------------------------------------------------------------------------

// What happens to an event without support: without a recent event among its eight neighbours.
enum class ClusterSupport {
  kOff,       // support is not computed; the noise rate follows from events that no cluster takes
  kEstimate,  // the event counts for the noise rate
  kReject,    // the event counts for the noise rate and goes to no cluster
};

// One setting serves all scenes it was tried on, so most users change none.
struct ClusterTrackerConfig {
  int width;        // px
  int height;       // px
  int slots = 128;  // clusters at a time, tentative ones included, 1 to 256

  ClusterSupport support = ClusterSupport::kReject;
  // Greatest age of a neighbour that gives support. In little noise it grows, up to 15 ms.
  std::chrono::nanoseconds support_window = std::chrono::milliseconds(5);

  double birth_radius_px = 18;  // circular gate of a young cluster; alone, up to 5/3 of it
  double max_radius_px = 66;    // longest half-axis of the elliptic gate of a mature one
  double confirm_events = 14;   // recent events from which it has an id; a small one 4/7 of it

  // Time from too few events to deletion. The velocity decays meanwhile: what stops keeps its id
  // for it, what moves on behind something for some .15 s. An object keeps its id for longer.
  std::chrono::nanoseconds coast = std::chrono::milliseconds(250);
};

// ---- the tracker -------------------------------------------------------------------------------

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

  // Takes the events, and labels[i] is the id of the cluster that took events[i]: -1 for noise, for
  // a cluster that is not confirmed yet, and for dropped events. Throws std::invalid_argument if
  // the sizes differ.
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

  // The objects at the latest time: one cluster or several that are parts of one thing, at the
  // position of the heaviest, with the box of all. Sorted by id, positions predicted for that time.
  // An object that has stopped or is occluded is not listed, but keeps its id for half a second. A
  // patch of noise and a light that flickers are clusters and no objects. An object has the id of
  // the cluster that founded it, or one that no cluster has.
  std::vector<TrackedObject> objects() const;
  void objects(std::vector<TrackedObject>& objects) const;

  // As clusters_at().
  std::vector<TrackedObject> objects_at(std::int64_t t_us) const;
  void objects_at(std::int64_t t_us, std::vector<TrackedObject>& objects) const;

  // Makes labels of clusters those of the objects whose parts the clusters are now: -1 for a
  // cluster that is no part of an object or has ended.
  void to_objects(std::span<std::int32_t> labels) const noexcept;

  // The ids of the clusters that are parts of the object with this id; the first is the heaviest,
  // whose position is the object's. Empty: `objects` does not list it.
  std::vector<std::int64_t> members(std::int64_t id) const;

  // The outline of the object with this id. Empty: `objects` does not list it.
  std::optional<ClusterOutline> outline(std::int64_t id) const;

  // Advances the time to t_us when it is known that no event came: clusters stop, coast and are
  // deleted. Later events with older timestamps count as of t_us. Does nothing before the first
  // event and for a t_us of the past. To look ahead, use clusters_at().
  void advance_to(std::int64_t t_us) noexcept;

  // Tells the share of the next events that thinning kept, in [0, 1]; what counts events adapts to
  // its mean over the latest ones. For every package. `filter_upstream`: a noise filter stands
  // before the thinning. Throws std::invalid_argument if gamma is out of range.
  void set_gamma(double gamma, bool filter_upstream = false);

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
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// The same, for a program without exceptions; or a PublishedClusterTracker:
// make_tracker<PublishedClusterTracker>({...}).
template <class Made = ClusterTracker>
Result<Made> make_tracker(const typename Made::Config& config) noexcept;

}  // namespace asap::inline v0_1
