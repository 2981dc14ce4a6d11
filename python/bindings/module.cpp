// The extension asap._core: a table of contents. One file per layer of the C++ core, no logic but
// how it begins and ends.
#include <pybind11/pybind11.h>

#include "asap/version.hpp"
#include "gil.hpp"
#include "layers.hpp"

namespace {

// Types stay registered, with NumPy too, whatever becomes of the import: what may take long, and so
// be interrupted, comes before them.
void begin_once() {
  static bool has_begun = false;
  pybind11::module_::import("numpy");
  asap::python::watch_exit_and_fork();
  if (has_begun) {
    throw pybind11::import_error(
        "asap: an import in this process did not come to its end; start Python anew");
  }
  has_begun = true;
}

pybind11::object refuse_to_pickle(const pybind11::object& self) {
  const auto name = pybind11::cast<std::string>(pybind11::type::of(self).attr("__name__"));
  throw pybind11::type_error("cannot pickle " + name);
}

// What would end the process otherwise: pickle of protocol 0 or 1, which calls the nameless base
// class of pybind11, and an object that is told that it is of another class of ours.
void close_classes(const pybind11::module_& m) {
  namespace py = pybind11;
  const py::handle plain(reinterpret_cast<PyObject*>(&PyBaseObject_Type));
  for (const auto& [name, item] : py::cast<py::dict>(m.attr("__dict__"))) {
    if (PyType_Check(item.ptr()) == 0) continue;
    if (item.attr("__reduce__").is(plain.attr("__reduce__"))) {
      item.attr("__reduce__") = py::cpp_function(&refuse_to_pickle, py::is_method(item));
    }
    reinterpret_cast<PyTypeObject*>(item.ptr())->tp_flags |= Py_TPFLAGS_IMMUTABLETYPE;
  }
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "Native core of asap.";
  m.attr("__version__") = std::string(asap::kVersion);

  begin_once();
  asap::python::bind_filter(m);
  asap::python::bind_validator(m);
  asap::python::bind_schemes(m);
  asap::python::bind_telemetry(m);
  asap::python::bind_runner(m);
  asap::python::bind_pipeline(m);
  asap::python::bind_study(m);
  asap::python::bind_rivals(m);
  asap::python::bind_formats(m);
  asap::python::bind_columns(m);
  asap::python::bind_decoders(m);
  asap::python::bind_packets(m);
  asap::python::bind_record_decoders(m);
  asap::python::bind_synthetic(m);
  asap::python::bind_scenes(m);
  asap::python::bind_algorithms(m);
  asap::python::bind_corners(m);
  asap::python::bind_hot_pixels(m);
  asap::python::bind_surfaces(m);
  asap::python::bind_flow(m);
  asap::python::bind_event_image(m);
  asap::python::bind_features(m);
  close_classes(m);
}
