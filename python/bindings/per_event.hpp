// What every event-by-event algorithm has in Python besides its constructor and process.
#pragma once

#include <pybind11/pybind11.h>

namespace asap::python {

namespace py = pybind11;

// `parameters` makes the dict of the constructor's keyword parameters.
template <class Algorithm>
void bind_rest(py::class_<Algorithm>& type, const char* name,
               py::dict (*parameters)(const typename Algorithm::Config&), const char* keep_doc) {
  type.def("set_keep", &Algorithm::set_keep, py::arg("gamma"), keep_doc)
      .def("reset", &Algorithm::reset, "Back to the state after construction.")
      .def_property_readonly(
          "width", [](const Algorithm& self) { return self.config().width; }, "px")
      .def_property_readonly(
          "height", [](const Algorithm& self) { return self.config().height; }, "px")
      .def_property_readonly(
          "name", [name](const Algorithm&) { return name; }, "Name of the algorithm in reports.")
      .def_property_readonly(
          "parameters", [parameters](const Algorithm& self) { return parameters(self.config()); },
          "dict of the constructor's keyword parameters.")
      .def_property_readonly("rejected", &Algorithm::rejected,
                             "Events dropped because they lie outside the frame.");
}

}  // namespace asap::python
