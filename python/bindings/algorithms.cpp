// The layer `algorithms`: ClusterTracker.
#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/core/check.hpp"
#include "layers.hpp"

namespace asap::python {
namespace {

constexpr const char* kClusterTrackerDoc = R"(Finds the moving objects in a stream, event by event.

An event joins the oldest cluster whose centre, or one of whose randomly probed events, lies within
`radius`; it merges all others for which that holds; where there is none it founds a new cluster. Only
the last `window` events count, over all clusters together.

Parameters
----------
width, height : int
    Size of the sensor, px. Events outside are dropped and counted in `rejected`.
engine : str
    "compat": the results of the published rule, with its parameters below.
window : int
    S, events that are remembered, 1 to 65535.
radius : float
    R, px, L1 distance.
probes : int
    kappa, live events of a cluster that are tried at random beside its centre.
weight : float
    alpha, weight of the newest event in the centre, 0 to 1.
min_size : int
    minN, events from which a cluster has an id and is listed, and beyond which it is probed.
seed : int
    Of the probes. The same seed and events give the same results on every platform.

Raises
------
ValueError
    A parameter is out of range; the message names it.

Notes
-----
The cost of an event does not depend on the number of clusters. One thread at a time.

The window is exactly the last `window` events; the authors' release, which forgets by time, keeps more
where stamps are equal. Source: Rodriguez-Gomez et al., "Asynchronous Event-Based Clustering and Tracking
for Intrusion Monitoring in UAS", ICRA 2020; the defaults are the launch values of its release.
)";

std::unique_ptr<ClusterTracker> make_tracker(int width, int height, const std::string& engine,
                                             int window, double radius, int probes, double weight,
                                             int min_size, const py::object& seed) {
  if (engine != "compat") throw_bad_value("engine", engine, "must be \"compat\"");
  return std::make_unique<ClusterTracker>(ClusterConfig{.width = width,
                                                        .height = height,
                                                        .window = window,
                                                        .radius = radius,
                                                        .probes = probes,
                                                        .weight = weight,
                                                        .min_size = min_size,
                                                        .seed = whole_number("seed", seed)});
}

py::dict parameters(const ClusterTracker& tracker) {
  const ClusterConfig& config = tracker.config();
  using namespace py::literals;
  return py::dict("engine"_a = "compat", "window"_a = config.window, "radius"_a = config.radius,
                  "probes"_a = config.probes, "weight"_a = config.weight,
                  "min_size"_a = config.min_size, "seed"_a = config.seed);
}

std::optional<py::array_t<std::int32_t>> process(ClusterTracker& tracker, const py::array& events,
                                                 bool labels) {
  const EventSpan span = as_span(events);
  std::vector<std::int32_t> ids(labels ? span.size() : 0);
  {
    // Pure C++ on memory that `events` keeps alive: other Python threads may run.
    const py::gil_scoped_release release;
    if (labels) {
      tracker.process(span, ids);
    } else {
      tracker.process(span);
    }
  }
  if (!labels) return std::nullopt;
  return moved_to_array(std::move(ids));
}

}  // namespace

void bind_algorithms(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(Cluster, id, x, y, vx, vy, cxx, cxy, cyy, size, t_last);

  constexpr ClusterConfig kDefault{.width = 0, .height = 0};
  py::class_<ClusterTracker>(m, "ClusterTracker", kClusterTrackerDoc)
      .def(py::init(&make_tracker), py::arg("width"), py::arg("height"), py::kw_only(),
           py::arg("engine") = "compat", py::arg("window") = kDefault.window,
           py::arg("radius") = kDefault.radius, py::arg("probes") = kDefault.probes,
           py::arg("weight") = kDefault.weight, py::arg("min_size") = kDefault.min_size,
           py::arg("seed") = kDefault.seed)
      .def("process", &process, py::arg("events").noconvert(), py::arg("labels") = true,
           R"(Takes the next events of the stream.

Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE
labels : bool
    False: no array is made.

Returns
-------
ndarray of int32, shape (n,), or None
    The id of the cluster that took each event. -1: it has no id yet, for want of `min_size` events, or
    the event lies outside the frame.

Raises
------
TypeError
    `events` is not a contiguous array in EVENT_DTYPE; convert with asap.as_events.
)")
      .def_property_readonly(
          "clusters",
          [](const ClusterTracker& tracker) { return moved_to_array(tracker.clusters()); },
          R"(Structured array, one row per cluster of at least `min_size` events, sorted by id.

id : int64, never changes while the cluster lives; a merge keeps the smaller
x, y : float64, px, mean of the live events
vx, vy : float64, px/s, regression of x and y on t over the live events: rough for windows of ms
cxx, cxy, cyy : float64, px^2, covariance of the live events
size : int64, live events
t_last : int64, us, stamp of the newest event

A new array, not changed by later events.
)")
      .def("set_keep", &ClusterTracker::set_keep, py::arg("gamma"),
           R"(Tells the fraction of the events that reaches the tracker, 0 <= gamma <= 1.

Checked, without effect in "compat": its window counts events and so stretches in time by itself.

Raises
------
ValueError
    gamma is NaN or outside [0, 1].
)")
      .def(
          "reset", &ClusterTracker::reset,
          "Back to the state after construction, seed included: the same events, the same results.")
      .def_property_readonly(
          "width", [](const ClusterTracker& tracker) { return tracker.config().width; }, "px")
      .def_property_readonly(
          "height", [](const ClusterTracker& tracker) { return tracker.config().height; }, "px")
      .def_property_readonly(
          "name", [](const ClusterTracker&) { return "clusters"; },
          "Name of the algorithm in reports.")
      .def_property_readonly("parameters", &parameters,
                             "dict of the constructor's keyword parameters.")
      .def_property_readonly("rejected", &ClusterTracker::rejected,
                             "Events dropped because they lie outside the frame.");
}

}  // namespace asap::python
