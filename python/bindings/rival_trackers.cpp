// The layer `study`, its rival trackers: baselines of the cluster tracker, with its face.
#include <cstdint>

#include "arrays.hpp"
#include "layers.hpp"
#include "per_event.hpp"
#include "study/jaer_cluster_tracker.hpp"
#include "study/owner_cell_tracker.hpp"

#include <pybind11/stl.h>

namespace asap::python {
namespace {

template <class Tracker>
void bind_face(py::class_<Tracker>& bound, const char* name) {
  bound
      .def("process", &process_labelled<Tracker>, py::arg("events").noconvert(),
           py::arg("labels") = true, "As ClusterTracker.process.")
      .def_property_readonly(
          "clusters",
          [](const Tracker& tracker) -> py::array { return moved_to_array(tracker.clusters()); },
          "As ClusterTracker.clusters; pxx, pxy and pyy are not known.")
      .def(
          "clusters_at",
          [](const Tracker& tracker, std::int64_t t_us) -> py::array {
            return moved_to_array(tracker.clusters_at(t_us));
          },
          py::arg("t_us"), "The same, positions predicted for t_us, us.")
      .def("reset", &Tracker::reset, "Back to the state after construction.")
      .def_property_readonly(
          "width", [](const Tracker& tracker) { return tracker.config().width; }, "px")
      .def_property_readonly(
          "height", [](const Tracker& tracker) { return tracker.config().height; }, "px")
      .def_property_readonly(
          "name", [name](const Tracker&) { return name; }, "Name of the algorithm in reports.")
      .def_property_readonly("rejected", &Tracker::rejected,
                             "Events dropped because they lie outside the frame.");
}

}  // namespace

void bind_rival_trackers(py::module_& m) {
  py::class_<JaerClusterTracker> jaer(
      m, "JaerClusterTracker",
      "The core of jAER's RectangularClusterTracker, built from its rules: boxes of 32 px that "
      "every event inside draws nearer.");
  jaer.def(py::init([](int width, int height) {
             return JaerClusterTracker({.width = width, .height = height});
           }),
           py::arg("width"), py::arg("height"));
  bind_face(jaer, "jaer-type core");

  py::class_<OwnerCellTracker> first(m, "OwnerCellTracker",
                                     "The first design of ClusterTracker's fast engine. radius_px, "
                                     "16 to 23: of the gate, px; must "
                                     "cover the largest object.");
  first
      .def(py::init([](int width, int height, int radius_px) {
             return OwnerCellTracker({.width = width, .height = height, .radius_px = radius_px});
           }),
           py::arg("width"), py::arg("height"), py::kw_only(), py::arg("radius_px") = 16)
      .def("set_keep", &OwnerCellTracker::set_keep, py::arg("gamma"),
           "The fraction of the events that reaches it, 0 to 1: its means remember fewer events.")
      .def_property_readonly(
          "radius_px", [](const OwnerCellTracker& tracker) { return tracker.config().radius_px; },
          "px");
  bind_face(first, "first design");
}

}  // namespace asap::python
