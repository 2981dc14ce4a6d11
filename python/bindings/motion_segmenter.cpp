// The layer `algorithms`: MotionSegmenter.
#include "asap/algorithms/motion_segmenter.hpp"
#include "arrays.hpp"
#include "per_event.hpp"

namespace asap::python::motion_segmenter {
namespace {

constexpr const char* kSegmenterDoc = R"(Finds what moves on its own before a moving camera.

Every 10 ms the normal flow of the last 15 ms (`PlaneFlow`) gives the motion of the background: shift, turn
and zoom, robustly. Cells of 8 px whose flow needs a shift beside it, significant and faster than `min_px_s`
+ `min_share` x the background's speed, are flagged; five or more that touch are a region, and regions are
followed. Where the flow does not cover the frame, the answer is "unknown": before a camera at rest, mostly, and
before a scene with few edges.

$sensor.
window_us : int
    us, 1 to 10 000 000, that of the flow: edges must cover some 3 px in it, of slower ones the flow is too
    fast, and with it `camera_motion`.
min_px_s : float
    px/s, 0 to 10**6: least speed against the background, and
min_share : float
    0 to 100: this share of the background's own speed, which keeps depth out.

$refuses

Notes
-----
Depth and motion are not separated: a thing much nearer than the background moves unlike it. Threads take
turns. A timestamp that goes back by up to 1 s counts as the latest one. Own design; the residual of a global
motion is that of Vasco et al., "Independent Motion Detection with Event-driven Cameras", ICAR 2017.

$scene
>>> segmenter = asap.MotionSegmenter(scene.width, scene.height)
>>> segmenter.process(events)
>>> segmenter.objects.dtype.names[:5]
('id', 'x', 'y', 'vx', 'vy')
)";

constexpr const char* kObjectsDoc =
    R"(Structured array, one row per thing that moves unlike the background.

id : int64, never changes while it is followed; sorted by it
x, y : float64, px, the middle of its box, predicted for the latest event
vx, vy : float64, px/s, in the picture, from its flow
left, top, width, height : float64, px, its box
size : int64, flow events of the last 15 ms that the background does not explain
t_last : int64, us, timestamp of the newest of them
age_us : int64, us since it was first seen
independent : float64, 1; -1 while the background's motion is unknown, in which time objects end after 30 ms

A new array, not changed by later events.
)";

constexpr const char* kCameraDoc = R"(The motion of the background, or None: unknown.

A row with the fields t (int64, us: it is that of the 15 ms before), vx, vy (float64, px/s, of the background at
the middle of the frame), turn (rad/s, from x to the right towards y downwards), zoom (1/s, growth of the
picture) and covariance (float64, 4 x 4), of the error of these four by the scatter of the flow. An error
common to all flow, such as that of edges too slow for `window_us`, is not in it. At (x, y) the background moves with
vx - turn (y - cy) + zoom (x - cx) and vy + turn (x - cx) + zoom (y - cy), (cx, cy) the middle of the frame.
)";

py::object camera_motion(const MotionSegmenter& segmenter) {
  const auto found = segmenter.camera_motion();
  if (!found) return py::none();
  return moved_to_array(std::vector{*found})[py::int_(0)];
}

void bind(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(CameraMotion, t, vx, vy, turn, zoom, covariance);

  using Config = MotionSegmenterConfig;
  Class<MotionSegmenter> type(m, "MotionSegmenter", documented(kSegmenterDoc).c_str());
  bind_taking(type);
  const auto objects = [](const MotionSegmenter& self) { return moved_to_array(self.objects()); };
  type.def_property_readonly("objects", objects, kObjectsDoc)
      .def(
          "objects_at",
          [](const MotionSegmenter& self, std::int64_t t_us) -> py::array {
            return moved_to_array(self.objects_at(t_us));
          },
          py::arg("t_us").noconvert(),
          "What `objects` would be at t_us, us, if nothing came until then. A t_us of the past is "
          "the latest time.")
      .def_property_readonly("camera_motion", &camera_motion, kCameraDoc);
  bind_rest(
      type, "motion",
      sized<Config>({keyword("window_us", &Config::window), keyword("min_px_s", &Config::min_px_s),
                     keyword("min_share", &Config::min_share)}),
      R"(The flow that "known" asks for goes with it.)");
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::motion_segmenter
