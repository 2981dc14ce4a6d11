#include "arguments.hpp"

#include "asap/core/check.hpp"

namespace asap::python {
namespace {

namespace py = pybind11;

constexpr std::size_t kLongest = 200;

}  // namespace

std::string shown(py::handle value) {
  std::string text;
  try {
    text = py::cast<std::string>(py::repr(value));
  } catch (const std::exception&) {  // a whole number may have too many digits to be written
    text = "<" + py::cast<std::string>(py::type::of(value).attr("__name__")) + ">";
  }
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest;
  while ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // within a character
  return text.substr(0, end) + "...";
}

std::uint64_t whole_number(const char* field, const py::object& value) {
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) {
    if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw py::error_already_set();
    PyErr_Clear();
    throw py::type_error(std::string(field) + " = " + shown(value) + ": give a whole number");
  }
  const std::uint64_t result = PyLong_AsUnsignedLongLong(number.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw_bad_value(field, shown(number), "must be at least 0 and below 2**64");
  }
  return result;
}

}  // namespace asap::python
