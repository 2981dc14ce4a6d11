// The extension asap_laboratory._native: what the experiments need in C++ and no product uses.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "arrays.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "native_consumer.hpp"
#include "parts.hpp"
#include "study/jaer_cluster_tracker.hpp"
#include "study/realtime.hpp"

namespace asap::python {
namespace {

py::array clusters_of(std::vector<Cluster> clusters) {
  const auto dtype = py::module_::import("asap._core").attr("CLUSTER_DTYPE").cast<py::dtype>();
  return moved_to_array(std::move(clusters), dtype);
}

std::optional<py::array> process(JaerClusterTracker& tracker, const py::array& events,
                                 bool labels) {
  const EventSpan span = as_span(events);
  std::vector<std::int32_t> ids(span.size());
  without_gil([&] { tracker.process(span, ids); });
  if (!labels) return std::nullopt;
  return moved_to_array(std::move(ids));
}

void bind_jaer_cluster_tracker(py::module_& m) {
  using Tracker = JaerClusterTracker;
  Class<Tracker>(
      m, "JaerClusterTracker",
      "The core of jAER's RectangularClusterTracker, built from its rules: boxes of 32 px "
      "that every event inside draws nearer.")
      .def(py::init(
               [](int width, int height) { return Tracker({.width = width, .height = height}); }),
           py::arg("width"), py::arg("height"))
      .def("process", &process, py::arg("events").noconvert(), py::arg("labels") = true,
           "As ClusterTracker.process.")
      .def_property_readonly(
          "clusters", [](const Tracker& self) { return clusters_of(self.clusters()); },
          "As ClusterTracker.clusters; pxx, pxy and pyy are not known.")
      .def(
          "clusters_at",
          [](const Tracker& self, std::int64_t t_us) {
            return clusters_of(self.clusters_at(t_us));
          },
          py::arg("t_us"), "The same, positions predicted for t_us, us.")
      .def("reset", &Tracker::reset, "Back to the state after construction.")
      .def_property_readonly(
          "width", [](const Tracker& self) { return self.config().width; }, "px")
      .def_property_readonly(
          "height", [](const Tracker& self) { return self.config().height; }, "px")
      .def_property_readonly(
          "name", [](const Tracker&) { return "jaer-type core"; }, "Its name in reports.")
      .def_property_readonly("rejected", &Tracker::rejected,
                             "Events dropped because they lie outside the frame.");
}

// ---- real time ----

void spin(void* algorithm, const Event* events, std::size_t size, double, bool continues) noexcept {
  auto* busy_wait = static_cast<BusyWait*>(algorithm);
  if (!continues) busy_wait->begin();
  busy_wait->process({events, size});
}

py::capsule consumer_of(BusyWait& busy_wait) {
  return py::capsule(new NativeConsumer{&busy_wait, &spin}, kNativeConsumer, [](PyObject* capsule) {
    delete static_cast<NativeConsumer*>(PyCapsule_GetPointer(capsule, kNativeConsumer));
  });
}

void bind_busy_wait(py::module_& m) {
  py::class_<BusyWait>(m, "BusyWait", R"(An algorithm of known cost in real time: it spins.

Parameters
----------
alpha_us : float
    At the start of a package, us.
beta_ns : float
    Per event, ns.
)")
      .def(py::init([](double alpha_us, double beta_ns) {
             return BusyWait({.alpha_us = alpha_us, .beta_ns = beta_ns});
           }),
           py::arg("alpha_us"), py::arg("beta_ns"))
      .def_property_readonly("name", [](const BusyWait&) { return "busy_wait"; })
      .def_property_readonly("parameters",
                             [](const BusyWait& self) {
                               return py::dict(py::arg("alpha_us") = self.config().alpha_us,
                                               py::arg("beta_ns") = self.config().beta_ns);
                             })
      .def_property_readonly(kNativeConsumer, &consumer_of)
      .def(
          "process",
          [](BusyWait& self, const py::array& events) {
            const EventSpan span = as_span(events);
            const WithoutGil release;  // nothing of Python is needed to spin
            self.begin();
            self.process(span);
          },
          py::arg("events").noconvert(), "Spins for a package of these events.");
}

}  // namespace
}  // namespace asap::python

PYBIND11_MODULE(_native, m) {
  m.doc() = "Native part of the laboratory.";
  pybind11::module_::import("asap._core");  // the types that ours derive from
  asap::python::watch_exit_and_fork();
  asap::python::bind_arrivals(m);
  asap::python::bind_clairvoyant(m);
  asap::python::bind_rivals(m);
  asap::python::bind_scenes(m);
  asap::python::bind_jaer_cluster_tracker(m);
  asap::python::bind_busy_wait(m);
  asap::python::close_classes(m);
}
