// The layer `algorithms`: PlaneFlow.
#include "asap/algorithms/plane_flow.hpp"
#include "arrays.hpp"
#include "per_event.hpp"

namespace asap::python::plane_flow {
namespace {

constexpr const char* kFlowDoc = R"(Optical flow of each event, normal to its edge, by a plane fit.

The times at which the pixels around fired lie near a plane, in the event's polarity and within
`window_us`; its slope is the inverse of the edge's velocity. An edge fires several events per pixel, and
only the first tells when it came: those that follow another one at their pixel within a quarter of
`window_us` have no flow. Nor has an event whose neighbours are not one edge.

$sensor.
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

$refuses

Notes
-----
Threads take turns. A timestamp that goes back by up to 1 s counts as the latest one. Source: Benosman, Clercq, Lagorce,
Ieng, Bartolozzi, "Event-Based Visual Flow", IEEE TNNLS 2014.

$scene
>>> flow = asap.PlaneFlow(scene.width, scene.height).process(events)
>>> flow.shape == (len(events), 2)
True
)";

void bind(py::module_& m) {
  using Config = PlaneFlowConfig;
  Class<PlaneFlow> type(m, "PlaneFlow", documented(kFlowDoc).c_str());
  bind_answering<float, Flow>(type, R"(ndarray of float32, shape (n, 2)
    vx and vy of each event, px/s, x to the right and y down. NaN where there is none: the events around
    are too few, all on a line, all at once or not one edge, or the event is not the first of its edge.)");
  bind_rest(
      type, "flow",
      sized<Config>({keyword("window_us", &Config::window),
                     keyword("min_points", &Config::min_points), keyword("refit", &Config::refit)}),
      "Checked, without effect: none is needed, and a longer window would reach back to edges that "
      "passed before.");
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::plane_flow
