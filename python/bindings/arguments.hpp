// Whole numbers from Python. pybind11 answers a negative one with a list of signatures; here it is
// a ValueError, and what is no number a TypeError, that names field and value, as everywhere.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <string>

#include "asap/core/check.hpp"

namespace asap::python {

// Any object with __index__; TypeError for others, ValueError unless 0 <= value < 2**64.
inline std::uint64_t whole_number(const char* field, const pybind11::object& value) {
  namespace py = pybind11;
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) {
    if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw py::error_already_set();
    PyErr_Clear();
    throw py::type_error(std::string(field) + " = " + py::cast<std::string>(py::repr(value)) +
                         ": give a whole number");
  }
  const std::uint64_t result = PyLong_AsUnsignedLongLong(number.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw_bad_value(field, py::cast<std::string>(py::str(number)),
                    "must be at least 0 and below 2**64");
  }
  return result;
}

}  // namespace asap::python
