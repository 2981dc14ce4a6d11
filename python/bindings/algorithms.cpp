// The layer `algorithms`: ClusterTracker, with either engine.
#include <pybind11/stl.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "cluster_trackers.hpp"
#include "core/check.hpp"
#include "layers.hpp"
#include "per_event.hpp"

namespace asap::python {
namespace {

using Tracker = EitherClusterTracker;

constexpr const char* kClusterTrackerDoc =
    R"(Finds and follows the moving objects in a stream, event by event.

Parameters
----------
width, height : int
    Size of the sensor, px. Events outside are dropped and counted in `rejected`.
engine : str
    "fast": own design. Noise is left out by itself; clusters have an outline, a velocity by Kalman
    filter, and an id that survives crossings, stops and short occlusions; `set_gamma` matters.
    "compat": exactly the published rule: an event joins the oldest cluster whose centre, or one of
    whose randomly probed events, lies within `radius`; it merges all others for which that holds;
    where there is none it founds a new cluster. Only the last `window` events count.
**parameters
    Of the engine, none needed. "compat": window=800 (S, events), radius=20.0 (R, px, L1 distance),
    probes=1 (kappa), weight=0.9 (alpha), min_size=15 (minN, events), seed=0 (of the probes), motion="window"
    (of the published rule; "kalman": x, y, vx, vy of a filter instead; what joins what stays the same).
    "fast": slots=128 (clusters at a time), support="reject" ("estimate": noise is counted and not left
    out; "off"), support_window_ms=5.0 (a neighbour that fired within it makes an event no noise),
    birth_radius_px=18.0 (least gate of a young cluster), max_radius_px=66.0 (longest half-axis of the
    gate), confirm_events=14.0 (recent events from which it has an id), coast_ms=250.0 (how long an id
    outlives its events).

$refuses
TypeError
    The engine has no such parameter, or the value is no number.

Notes
-----
The cost of an event does not depend on the number of clusters. Threads take turns. The same events
(and seed) give the same results however they are cut into calls.

Source of "compat": Rodriguez-Gomez et al., "Asynchronous Event-Based Clustering and Tracking for
Intrusion Monitoring in UAS", ICRA 2020; the defaults are the launch values of its release. Its window
is exactly the last `window` events; the release, which forgets by time, keeps more where stamps are equal.
motion="kalman" is not of that paper: the constant-velocity filter of "fast", over the mean of the events
of every ms or more, 8 at least; after a second without it begins anew.
)";

constexpr Choices<ClusterSupport, 3> kSupports{{{"off", ClusterSupport::kOff},
                                                {"estimate", ClusterSupport::kEstimate},
                                                {"reject", ClusterSupport::kReject}}};

constexpr Choices<PublishedClusterMotion, 2> kMotions{
    {{"window", PublishedClusterMotion::kWindow}, {"kalman", PublishedClusterMotion::kKalman}}};

// It has chosen the table by then.
template <class Config>
Keyword<Config> engine(const char* name) {
  return {.name = "engine",
          .set = [](Config&, py::handle) {},
          .get = [name](const Config&) { return py::str(name); }};
}

const Keywords<ClusterTrackerConfig>& keywords_of(const ClusterTrackerConfig&) {
  using Config = ClusterTrackerConfig;
  static const auto all = sized<Config>({engine<Config>("fast"), keyword("slots", &Config::slots),
                                         keyword("support", &Config::support, kSupports),
                                         keyword("support_window_ms", &Config::support_window),
                                         keyword("birth_radius_px", &Config::birth_radius_px),
                                         keyword("max_radius_px", &Config::max_radius_px),
                                         keyword("confirm_events", &Config::confirm_events),
                                         keyword("coast_ms", &Config::coast)});
  return all;
}

const Keywords<PublishedClusterTrackerConfig>& keywords_of(const PublishedClusterTrackerConfig&) {
  using Config = PublishedClusterTrackerConfig;
  static const auto all =
      sized<Config>({engine<Config>("compat"), keyword("window", &Config::window),
                     keyword("radius", &Config::radius), keyword("probes", &Config::probes),
                     keyword("weight", &Config::weight), keyword("min_size", &Config::min_size),
                     keyword("seed", &Config::seed), keyword("motion", &Config::motion, kMotions)});
  return all;
}

template <class Config>
Config config_from(const char* owner, const py::args& values, const py::kwargs& given) {
  return config_of(owner, keywords_of(Config{}), values, given);
}

Tracker* make_tracker(const py::args& values, const py::kwargs& given) {
  const py::object engine = given.contains("engine") ? given["engine"] : py::str("fast");
  if (engine.equal(py::str("fast"))) {
    return new Tracker{
        ClusterTracker(config_from<ClusterTrackerConfig>("engine \"fast\"", values, given))};
  }
  if (engine.equal(py::str("compat"))) {
    return new Tracker{PublishedClusterTracker(
        config_from<PublishedClusterTrackerConfig>("engine \"compat\"", values, given))};
  }
  throw_bad_value("engine", shown(engine), "must be \"fast\" or \"compat\"");
}

// The arguments of an engine by name, from one on.
py::dict arguments_of(const Tracker& tracker, std::size_t from) {
  return std::visit(
      [from](const auto& engine) {
        return told(keywords_of(engine.config()), engine.config(), from);
      },
      tracker.engine);
}

std::optional<py::array_t<std::int32_t>> process(Tracker& tracker, const py::array& events,
                                                 bool labels) {
  return std::visit([&](auto& engine) { return process_labelled(engine, events, labels); },
                    tracker.engine);
}

py::array clusters(const Tracker& tracker) {
  return std::visit(
      [](const auto& engine) -> py::array { return moved_to_array(engine.clusters()); },
      tracker.engine);
}

py::array clusters_at(const Tracker& tracker, std::int64_t t_us) {
  return std::visit(
      [t_us](const auto& engine) -> py::array { return moved_to_array(engine.clusters_at(t_us)); },
      tracker.engine);
}

// A row of a structured array: it pickles, and its fields go by name like those of `clusters`.
py::object row_of(const ClusterOutline& outline) {
  return moved_to_array(std::vector{outline})[py::int_(0)];
}

[[noreturn]] void throw_no_key(std::int64_t id) {
  PyErr_SetObject(PyExc_KeyError, py::int_(id).ptr());
  throw py::error_already_set();
}

py::object outline(const Tracker& tracker, std::int64_t id) {
  const auto found =
      std::visit([id](const auto& engine) { return engine.outline(id); }, tracker.engine);
  if (!found) throw_no_key(id);
  return row_of(*found);
}

// The engine with objects. hasattr() is false for the other.
const ClusterTracker& with_objects(const Tracker& tracker) {
  if (const auto* fast = std::get_if<ClusterTracker>(&tracker.engine)) return *fast;
  throw py::attribute_error("engine = compat: has clusters and no objects. Use engine=\"fast\"");
}

py::array objects(const Tracker& tracker) {
  return moved_to_array(with_objects(tracker).objects());
}

py::array objects_at(const Tracker& tracker, std::int64_t t_us) {
  return moved_to_array(with_objects(tracker).objects_at(t_us));
}

py::array members(const Tracker& tracker, std::int64_t id) {
  auto found = with_objects(tracker).members(id);
  if (found.empty()) throw_no_key(id);
  return moved_to_array(std::move(found));
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

void advance_to(Tracker& tracker, std::int64_t t_us) {
  if (auto* fast = std::get_if<ClusterTracker>(&tracker.engine)) fast->advance_to(t_us);
}

void set_gamma(Tracker& tracker, double gamma, bool filter_upstream) {
  if (auto* fast = std::get_if<ClusterTracker>(&tracker.engine)) {
    fast->set_gamma(gamma, filter_upstream);
  } else {
    std::get<PublishedClusterTracker>(tracker.engine).set_gamma(gamma);
  }
}

// What only the fast engine counts.
template <std::uint64_t (ClusterTracker::*Count)() const noexcept>
std::uint64_t count(const Tracker& tracker) {
  const auto* fast = std::get_if<ClusterTracker>(&tracker.engine);
  return fast == nullptr ? 0 : (fast->*Count)();
}

template <class Read>
auto reading(Read read) {
  return [read](const Tracker& tracker) { return std::visit(read, tracker.engine); };
}

// For the signature: the arguments of either engine, with its defaults.
py::dict defaults_of_engines() {
  const ClusterTrackerConfig fast{};
  const PublishedClusterTrackerConfig compat{};
  py::dict all = told(keywords_of(fast), fast);
  for (const auto& [name, value] : told(keywords_of(compat), compat)) {
    if (!all.contains(name)) all[name] = value;
  }
  return all;
}

}  // namespace

void bind_algorithms(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(Cluster, id, x, y, vx, vy, cxx, cxy, cyy, size, t_last, pxx, pxy, pyy);
  PYBIND11_NUMPY_DTYPE(ClusterOutline, x, y, major, minor, angle);
  PYBIND11_NUMPY_DTYPE(TrackedObject, id, x, y, vx, vy, left, top, width, height, size, t_last,
                       age_us, independent);
  m.attr("CLUSTER_DTYPE") = py::dtype::of<Cluster>();
  m.def("outline_of", &outline_of_moments, py::arg("x"), py::arg("y"), py::arg("cxx"),
        py::arg("cxy"), py::arg("cyy"), "As ClusterTracker.outline, of these fields of a cluster.");

  Class<Tracker> bound(m, "ClusterTracker", documented(kClusterTrackerDoc).c_str());
  const py::dict defaults = defaults_of_engines();
  def_constructor(bound, signature_of(defaults, 2), &make_tracker);
  bind_arguments(bound, &arguments_of, defaults, 2);
  bind_reset(bound,
             "Back to the state after construction, seed included: the same events, the same "
             "results.");
  bind_process(bound, &process, R"(Takes the next events of the stream.

$events
labels : bool
    False: no array is made.

Returns
-------
ndarray of int32, shape (n,), or None
    The id of the cluster that took each event. -1: noise, a cluster that has no id yet, or outside the
    frame.

$not_events
)",
               py::arg("labels") = true);
  bound
      .def_property_readonly("clusters", &clusters,
                             R"(Structured array, one row per cluster that has an id, sorted by id.

id : int64, never changes while the cluster lives; a merge keeps the smaller
x, y : float64, px. "fast": centre of the outline, predicted for the latest time. "compat": mean of the
    live events; with motion="kalman" of a filter over the means of every ms, predicted likewise
vx, vy : float64, px/s. "fast": Kalman filter. "compat": regression of x and y on t over the live
    events, rough for windows of ms; with motion="kalman" of the filter, 0 at first
cxx, cxy, cyy : float64, px^2, covariance of its events: its extent
size : int64. "fast": events of about the last 30 ms. "compat": live events
t_last : int64, us, stamp of the newest event
pxx, pxy, pyy : float64, px^2, covariance of the error of x and y. "fast": of the Kalman filter, and of
    the outline's centre, which is only as good as the edges that have been seen. "compat", which does
    not know it: infinite, pxy = 0

A new array, not changed by later events. "fast" leaves out objects that have stopped or are hidden; they
keep their id for a while.
)")
      .def("clusters_at", &clusters_at, py::arg("t_us").noconvert(),
           R"(What `clusters` would be at t_us, us, if nothing came until then.

Asking changes nothing: events of before t_us may follow. "fast": positions are predicted, and objects
without events are left out in time. "compat": `clusters`; with motion="kalman" positions are predicted, up
to 0.1 s ahead. A t_us of the past is the latest time.
)")
      .def_property_readonly("objects", &objects,
                             R"(Structured array, one row per thing that moves, sorted by id.

An object is a cluster, or several that are parts of one thing; noise that is denser in one place and
a flickering light are clusters and no objects. Grouped every 5 ms of event time.

id : int64, never changes; an object that has stopped or is hidden is left out, and has its id again
    when it is back where it must be within half a second
x, y : float64, px, of its heaviest cluster, predicted for the latest time
vx, vy : float64, px/s, of the same
left, top, width, height : float64, px, the box of its clusters, 1.75 standard deviations to each side
size : int64, events of about the last 30 ms
t_last : int64, us, stamp of the newest event
age_us : int64, us since it began
independent : float64, 0 to 1, whether it moves unlike the background; -1: not known

AttributeError in "compat", which has clusters alone.
)")
      .def("objects_at", &objects_at, py::arg("t_us").noconvert(),
           R"(What `objects` would be at t_us, us, if nothing came until then; see `clusters_at`.)")
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
      .def("outline", &outline, py::arg("id").noconvert(),
           R"(The ellipse of two standard deviations of an object's events.

Parameters
----------
id : int
    That of an object; in "compat" of a cluster.

Returns
-------
numpy.void
    A row with the float64 fields x, y (px, centre), major, minor (px, half-axes) and angle (rad, of the
    major axis, from x to the right towards y downwards, -pi/2 to pi/2).

Raises
------
KeyError
    There is no such id now.
)")
      .def("advance_to", &advance_to, py::arg("t_us").noconvert(),
           R"(Time has come to t_us, us, without events: in "fast" clusters starve, coast and die.

For whoever knows that no event came; to look ahead, `clusters_at`. Later events with older stamps count
as of t_us. Before the first event, for the past, and in "compat", which forgets by events alone: nothing
happens.
)")
      .def("set_gamma", &set_gamma, py::arg("gamma"), py::arg("filter_upstream") = false,
           R"(Tells the fraction of the events that reaches the tracker.

Parameters
----------
gamma : float
    0 <= gamma <= 1. 1 changes nothing. "fast" adapts all that counts events or looks for neighbours to
    the mean over the latest events; for every package. "compat" checks it: its window counts events and so stretches in
    time by itself.
filter_upstream : bool
    A noise filter stands before the discarder: "fast" rejects no more events as noise from 0.08 to 0.75;
    below it rejects none in either case.

Raises
------
ValueError
    gamma is NaN or outside [0, 1].
)")
      .def_property_readonly(
          "width", reading([](const auto& engine) { return engine.config().width; }), "px")
      .def_property_readonly(
          "height", reading([](const auto& engine) { return engine.config().height; }), "px")
      .def_property_readonly(
          "name", [](const Tracker&) { return "clusters"; }, "Name of the algorithm in reports.")
      .def_property_readonly(
          "engine",
          [](const Tracker& tracker) { return tracker.engine.index() == 0 ? "fast" : "compat"; },
          "\"fast\" or \"compat\".")
      .def_property_readonly("rejected",
                             reading([](const auto& engine) { return engine.rejected(); }),
                             "Events dropped because they lie outside the frame.")
      .def_property_readonly(
          "unsupported", &count<&ClusterTracker::unsupported>,
          "Events without a recent event among their neighbours; 0 in \"compat\".")
      .def_property_readonly("refused", &count<&ClusterTracker::refused>,
                             "Clusters not begun because all `slots` were taken; 0 in \"compat\".");
}

}  // namespace asap::python
