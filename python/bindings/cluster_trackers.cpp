// The layer `algorithms`: ClusterTracker and PublishedClusterTracker.
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "per_event.hpp"

namespace asap::python::cluster_trackers {
namespace {

constexpr const char* kClusterTrackerDoc =
    R"(Finds and follows the moving objects in a stream, event by event.

Noise is left out by itself. Clusters have an outline, a velocity by Kalman filter, and an id that survives
crossings, stops and short occlusions. `set_gamma` matters. `PublishedClusterTracker` is the published rule.

$sensor.
slots : int
    Clusters at a time, 1 to 256.
support : str
    "reject": an event without a recent event among its neighbours goes to no cluster; "estimate": such
    events are counted and not left out; "off".
support_window_ms : float
    ms, 0.001 to 60 000: a neighbour that fired within it makes an event no noise.
birth_radius_px : float
    px, 7 to 4096, least gate of a young cluster.
max_radius_px : float
    px, 7 to 4096, longest half-axis of the gate.
confirm_events : float
    Recent events from which a cluster has an id, 2 to 60 000.
coast_ms : float
    ms, 0.001 to 60 000: how long the id of a cluster that has stopped outlives its events. One that moves
    on unseen keeps it for some 150 ms; an object keeps its id for longer.

$refuses

Notes
-----
The cost of an event does not depend on the number of clusters. Threads take turns. The same events give
the same results however they are cut into calls. Own design.

$scene
>>> tracker = asap.ClusterTracker(scene.width, scene.height)
>>> ids = tracker.process(events)
>>> set(tracker.clusters["id"]) <= set(ids)
True
>>> tracker.objects[["x", "y", "vx", "vy"]].dtype.names
('x', 'y', 'vx', 'vy')
)";

constexpr const char* kPublishedDoc =
    R"(Finds clusters by the published rule, exactly: an event joins the oldest cluster that is near.

Near is a cluster whose centre, or one of whose randomly probed events, lies within `radius`. The event
merges all others that are near; where there is none it founds a new cluster. Only the last `window`
events count.

$sensor.
window : int
    S, events that are remembered, over all clusters, 1 to 65 535.
radius : float
    R, px, L1 distance.
probes : int
    kappa, events of each cluster that are tried beside its centre.
weight : float
    alpha, 0 to 1, of the newest event in the centre.
min_size : int
    minN, events from which a cluster is listed, and probed beyond.
seed : int
    Seed of the probes.

$refuses

Notes
-----
The cost of an event does not depend on the number of clusters. Threads take turns. The same events and
seed give the same results however they are cut into calls.

Source: Rodriguez-Gomez et al., "Asynchronous Event-Based Clustering and Tracking for Intrusion Monitoring
in UAS", ICRA 2020; the defaults are the launch values of its release. Its window is exactly the last
`window` events; the release, which forgets by time, keeps more where timestamps are equal.

$scene
>>> tracker = asap.PublishedClusterTracker(scene.width, scene.height)
>>> ids = tracker.process(events)
>>> set(tracker.clusters["id"]) <= set(ids)
True
)";

constexpr Choices<ClusterSupport, 3> kSupports{{{"off", ClusterSupport::kOff},
                                                {"estimate", ClusterSupport::kEstimate},
                                                {"reject", ClusterSupport::kReject}}};

// A row of a structured array: it pickles, and its fields go by name like those of `clusters`.
py::object row_of(const ClusterOutline& outline) {
  return moved_to_array(std::vector{outline})[py::int_(0)];
}

[[noreturn]] void throw_no_key(const PublishedClusterTracker&, std::int64_t id) {
  throw py::key_error("id = " + std::to_string(id) + ": no cluster has it. See `clusters`.");
}

[[noreturn]] void throw_no_key(const ClusterTracker& tracker, std::int64_t id) {
  const bool is_cluster = std::ranges::count(tracker.clusters(), id, &Cluster::id) > 0;
  throw py::key_error("id = " + std::to_string(id) +
                      (is_cluster ? ": a cluster, no object" : ": no object has it") +
                      ". Take an id of `objects`; `to_objects` finds a cluster's.");
}

py::object outline_of_moments(double x, double y, double cxx, double cxy, double cyy) {
  Cluster cluster{};
  cluster.x = x;
  cluster.y = y;
  cluster.cxx = cxx;
  cluster.cxy = cxy;
  cluster.cyy = cyy;
  return row_of(outline_of(cluster));
}

py::array members(const ClusterTracker& tracker, std::int64_t id) {
  auto found = tracker.members(id);
  if (found.empty()) throw_no_key(tracker, id);
  return moved_to_array(std::move(found));
}

py::array to_objects(const ClusterTracker& tracker, const py::array& labels) {
  if (!py::isinstance<py::array_t<std::int32_t, 0>>(labels)) {
    throw py::type_error("labels: not int32. Give what `process` returned.");
  }
  py::array made = labels.attr("copy")();
  tracker.to_objects(
      {static_cast<std::int32_t*>(made.mutable_data()), static_cast<std::size_t>(made.size())});
  return made;
}

// What both have.
template <class Tracker>
void bind_clusters(Class<Tracker>& type, const char* clusters, const char* clusters_at,
                   const char* outline) {
  bind_labelled(type, R"(ndarray of int32, shape (n,), or None
    The id of the cluster that took each event. -1: noise, a cluster that has no id yet, or outside the
    frame.)");
  type.def_property_readonly(
          "clusters", [](const Tracker& self) { return moved_to_array(self.clusters()); }, clusters)
      .def(
          "clusters_at",
          [](const Tracker& self, std::int64_t t_us) -> py::array {
            return moved_to_array(self.clusters_at(t_us));
          },
          py::arg("t_us").noconvert(), clusters_at)
      .def(
          "outline",
          [](const Tracker& self, std::int64_t id) {
            const auto found = self.outline(id);
            if (!found) throw_no_key(self, id);
            return row_of(*found);
          },
          py::arg("id").noconvert(), documented(outline).c_str());
}

void bind_cluster_tracker(py::module_& m) {
  using Config = ClusterTrackerConfig;
  Class<ClusterTracker> type(m, "ClusterTracker", documented(kClusterTrackerDoc).c_str());
  bind_clusters(type, R"(Structured array, one row per cluster that has an id, sorted by id.

id : int64, never changes while the cluster lives; a merge keeps the smaller
x, y : float64, px, centre of the outline, predicted for the latest time
vx, vy : float64, px/s, by Kalman filter
cxx, cxy, cyy : float64, px^2, covariance of its events: its extent
size : int64, events of about the last 30 ms
t_last : int64, us, timestamp of the newest event
pxx, pxy, pyy : float64, px^2, covariance of the error of x and y, by the Kalman filter, and of the
    outline's centre, which is only as good as the edges that have been seen

A new array, not changed by later events. Clusters that have stopped or are hidden are left out; they keep
their id for a while.
)",
                R"(Predicts `clusters` at t_us, us, as if no event came until then.

Asking changes nothing: events of before t_us may follow. Positions are predicted, and clusters without
events are left out in time. A t_us of the past is the latest time.
)",
                R"(The ellipse of two standard deviations of an object's events.

Parameters
----------
id : int
    That of an object.

$outline
)");
  const auto objects = [](const ClusterTracker& self) { return moved_to_array(self.objects()); };
  type.def_property_readonly("objects", objects,
                             R"(Structured array, one row per thing that moves, sorted by id.

An object is a cluster, or several that are parts of one thing; noise that is denser in one place
and a light that flickers are clusters and no objects. Grouped every 5 ms of event time.

id : int64, never changes: that of the cluster that founded it, or one that no cluster has; an object that
    has stopped or is hidden is left out, and has its id again when it is back where it must be within half
    a second
x, y : float64, px, of its heaviest cluster, predicted for the latest time
vx, vy : float64, px/s, of the same
left, top, width, height : float64, px, the box of the outlines of its clusters
size : int64, events of about the last 30 ms
t_last : int64, us, timestamp of the newest event
age_us : int64, us since it began
independent : float64, 0 to 1, whether it moves unlike the background; -1: not known
)")
      .def(
          "objects_at",
          [](const ClusterTracker& self, std::int64_t t_us) -> py::array {
            return moved_to_array(self.objects_at(t_us));
          },
          py::arg("t_us").noconvert(),
          R"(Predicts `objects` at t_us, us, as if no event came until then; see `clusters_at`.)")
      .def("members", &members, py::arg("id").noconvert(),
           R"(The ids of the clusters that are parts of an object.

Parameters
----------
id : int
    That of an object.

Returns
-------
ndarray of int64
    The heaviest first, whose position is the object's. `process` labels the events with these ids.

Raises
------
KeyError
    `objects` has no such id.
)")
      .def("to_objects", &to_objects, py::arg("labels").noconvert(),
           R"(Turns labels of clusters, as `process` returns them, into those of objects.

Parameters
----------
labels : ndarray of int32
    Ids of clusters, or -1.

Returns
-------
ndarray of int32, same shape
    The id of the object whose part each cluster is now; -1: of none, or it has ended.

Raises
------
TypeError
    The labels are no int32.
)")
      .def("advance_to", &ClusterTracker::advance_to, py::arg("t_us").noconvert(),
           R"(Time has come to t_us, us, without events: clusters starve, coast and die.

Call it where it is known that no event came; to look ahead, `clusters_at`. Later events with older timestamps
count as of t_us. Before the first event and for the past nothing happens.
)")
      .def_property_readonly("unsupported", &ClusterTracker::unsupported,
                             "Events without a recent event among their neighbours.")
      .def_property_readonly("refused", &ClusterTracker::refused,
                             "Clusters not begun because all `slots` were taken.");
  bind_rest(type, "clusters",
            sized<Config>({keyword("slots", &Config::slots),
                           keyword("support", &Config::support, kSupports),
                           keyword("support_window_ms", &Config::support_window),
                           keyword("birth_radius_px", &Config::birth_radius_px),
                           keyword("max_radius_px", &Config::max_radius_px),
                           keyword("confirm_events", &Config::confirm_events),
                           keyword("coast_ms", &Config::coast)}),
            nullptr);
  type.def("set_gamma", &ClusterTracker::set_gamma, py::arg("gamma"),
           py::arg("filter_upstream") = false,
           documented(R"(Tells the fraction of the events that reaches the tracker.

All that counts events or looks for neighbours adapts to the mean over the latest events; for every
package.

Parameters
----------
gamma : float
    0 <= gamma <= 1. 1 changes nothing.
filter_upstream : bool
    A noise filter stands before the thinning: no more events are rejected as noise from 0.08 to 0.75;
    below it none is in either case.

$not_gamma
)")
               .c_str());
}

void bind_published_cluster_tracker(py::module_& m) {
  using Config = PublishedClusterTrackerConfig;
  Class<PublishedClusterTracker> type(m, "PublishedClusterTracker",
                                      documented(kPublishedDoc).c_str());
  bind_clusters(type, R"(Structured array, one row per cluster of `min_size` events, sorted by id.

id : int64, never changes while the cluster lives; a merge keeps the smaller
x, y : float64, px, mean of the live events
vx, vy : float64, px/s, regression of x and y on t over the live events, rough for windows of ms
cxx, cxy, cyy : float64, px^2, covariance of its events: its extent
size : int64, live events
t_last : int64, us, timestamp of the newest event
pxx, pxy, pyy : float64, infinite and pxy = 0: the rule does not know the error of x and y

A new array, not changed by later events.
)",
                "`clusters`, for any t_us: events alone make the rule forget.",
                R"(The ellipse of two standard deviations of a cluster's events.

Parameters
----------
id : int
    That of a cluster.

$outline
)");
  bind_rest(
      type, "published_clusters",
      sized<Config>({keyword("window", &Config::window), keyword("radius", &Config::radius),
                     keyword("probes", &Config::probes), keyword("weight", &Config::weight),
                     keyword("min_size", &Config::min_size), keyword("seed", &Config::seed)}),
      "Checked, without effect: the window counts events, so it stretches in time by itself.");
}

void bind(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(Cluster, id, x, y, vx, vy, cxx, cxy, cyy, size, t_last, pxx, pxy, pyy);
  PYBIND11_NUMPY_DTYPE(ClusterOutline, x, y, major, minor, angle);
  PYBIND11_NUMPY_DTYPE(TrackedObject, id, x, y, vx, vy, left, top, width, height, size, t_last,
                       age_us, independent);
  m.attr("CLUSTER_DTYPE") = py::dtype::of<Cluster>();
  m.def("outline_of", &outline_of_moments, py::arg("x"), py::arg("y"), py::arg("cxx"),
        py::arg("cxy"), py::arg("cyy"), "As ClusterTracker.outline, of these fields of a cluster.");
  bind_cluster_tracker(m);
  bind_published_cluster_tracker(m);
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::cluster_trackers
