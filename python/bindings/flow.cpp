// The layer `algorithms`: PlaneFlow.

#include "arrays.hpp"
#include "asap/algorithms/plane_flow.hpp"
#include "gil.hpp"
#include "layers.hpp"
#include "per_event.hpp"

namespace asap::python {
namespace {

constexpr const char* kFlowDoc = R"(Optical flow of each event, normal to its edge, by a plane fit.

The times at which the pixels around fired lie near a plane, in the event's polarity and within
`window_us`; its slope is the inverse of the edge's velocity. An edge fires several events per pixel, and
only the first tells when it came: those that follow another one at their pixel within a quarter of
`window_us` have no flow. Nor has an event whose neighbours are not one edge.

Parameters
----------
width, height : int
    Size of the sensor, px, 1 to 16384. Events outside are dropped and counted in `rejected`.
window_us : int
    us, 1 to 10 000 000: older events do not count. Edges must cover some 3 px in it: of slower ones the
    flow is too fast.
min_points : int
    Fewest pixels of a fit, the event's own included, 3 to 25.
refit : bool or None
    None: the first events of an edge, 7 x 7 px; least squares with weights, twice without the outliers;
    refused if the points lie more than 0.7 px rms from the plane, along the edge's normal. A bool: the
    published rule, every event and 5 x 5 px; True: fitted a second time without the pixels farther from
    the first plane than twice the rms distance.

Raises
------
ValueError
    A parameter is out of range; the message names it.

Notes
-----
Threads take turns. A stamp that goes back counts as the latest one. Source: Benosman, Clercq, Lagorce,
Ieng, Bartolozzi, "Event-Based Visual Flow", IEEE TNNLS 2014.
)";

py::array_t<float> flows(PlaneFlow& flow, const py::array& events) {
  static_assert(sizeof(Flow) == 2 * sizeof(float));
  const EventSpan span = as_span(events);
  py::array_t<float> result({static_cast<py::ssize_t>(span.size()), py::ssize_t{2}});
  auto* out = reinterpret_cast<Flow*>(result.mutable_data());
  {
    // Pure C++ on memory that `events` keeps alive: other Python threads may run.
    const WithoutGil release;
    flow.process(span, {out, span.size()});
  }
  return result;
}

}  // namespace

void bind_flow(py::module_& m) {
  using Config = PlaneFlowConfig;
  Class<PlaneFlow> type(m, "PlaneFlow", kFlowDoc);
  type.def("process", &flows, py::arg("events").noconvert(),
           R"(Takes the next events of the stream.

Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE

Returns
-------
ndarray of float32, shape (n, 2)
    vx and vy of each event, px/s, x to the right and y down. NaN where there is none: the events around
    are too few, all on a line, all at once or not one edge, or the event is not the first of its edge.

Raises
------
TypeError
    `events` is not a contiguous array in EVENT_DTYPE; convert with asap.as_events.
)");
  bind_rest(
      type, "plane_flow",
      sized<Config>({keyword("window_us", &Config::window),
                     keyword("min_points", &Config::min_points), keyword("refit", &Config::refit)}),
      R"(Tells the fraction of the events that reaches the algorithm, 0 <= gamma <= 1.

Checked, without effect: none is needed, and a longer window would reach back to edges that passed before.

Raises
------
ValueError
    gamma is NaN or outside [0, 1].
)");
}

}  // namespace asap::python
