// The layer `algorithms`: FeatureTracker.
#include "asap/algorithms/feature_tracker.hpp"
#include "arrays.hpp"
#include "per_event.hpp"

namespace asap::python::feature_tracker {
namespace {

constexpr const char* kFeatureTrackerDoc =
    R"(Finds corners and follows them, event by event.

A corner event is supported if more than `min_neighbours` of its eight neighbours are remembered: among
the last `window` corner events, or younger than `window_us`. It then moves the oldest track within
`radius` to itself and ends all others there; where there is none it begins a track. A track of which no
event is remembered ends with the next supported event.

$sensor; those at the
    border are never tracked.
detector : str
    "arc_star", "e_fast", "e_harris" or "fa_harris": asap.ArcStar and so on, with its defaults;
    "every_event" if the events are corners already.
window : int
    B, corner events that are remembered at least, 1 to 65535.
radius : int
    px, how far a corner moves between two of its events, 0 to 16384: half of the release's search window w.
min_neighbours : int
    m, 0 to 7.
window_us : int
    us, corner events younger than this are remembered too, 0 to 10**9; at most 16384 or `window` of them.
    So the window grows with the corners: `window` alone leaves no track on texture. 0 is the release.
velocity_us : int
    us, how far back the velocity looks, 1 to 10**9. Without effect on anything else.

$refuses

Notes
-----
The cost of an event does not depend on the number of tracks. Threads take turns. A timestamp that goes back
by up to 1 s counts as the latest one. Source: the authors' release of the event feature tracker of the GRVC
(grvc_ef_tracker), which the ASAP papers use, with its launch values; `window_us`, ids and velocities are
ours.

$scene
>>> tracker = asap.FeatureTracker(scene.width, scene.height, detector="e_fast")
>>> ids = tracker.process(events)
>>> set(tracker.tracks["id"]) <= set(ids)
True
)";

constexpr Choices<CornerSource, 5> kDetectors{{{"arc_star", CornerSource::arc_star},
                                               {"e_fast", CornerSource::e_fast},
                                               {"e_harris", CornerSource::e_harris},
                                               {"fa_harris", CornerSource::fa_harris},
                                               {"every_event", CornerSource::every_event}}};

void bind(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(FeatureTrack, id, x, y, vx, vy, size, t_first, t_last);

  using Config = FeatureConfig;
  Class<FeatureTracker> type(m, "FeatureTracker", documented(kFeatureTrackerDoc).c_str());
  bind_labelled(type, R"(ndarray of int32, shape (n,), or None
    The id of the track that took each event. -1: it is no corner, an unsupported corner, or outside
    the frame.)");
  type.def_property_readonly(
      "tracks", [](const FeatureTracker& tracker) { return moved_to_array(tracker.tracks()); },
      R"(Structured array, one row per track, first begun first.

id : int64, never changes while the track lives
x, y : float64, px, of the newest event
vx, vy : float64, px/s, regression of x and y on t, older events weighing less by `velocity_us`; 0 until
    there are events at two times
size : int64, corner events that it took
t_first, t_last : int64, us, timestamps of its first and newest event

A new array, not changed by later events.
)");
  bind_rest(type, "features",
            sized<Config>({keyword("detector", &Config::detector, kDetectors),
                           keyword("window", &Config::window), keyword("radius", &Config::radius),
                           keyword("min_neighbours", &Config::min_neighbours),
                           keyword("window_us", &Config::window_time),
                           keyword("velocity_us", &Config::velocity_window)}),
            "`window_us` stretches, so that as many corner events are remembered.");
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::feature_tracker
