#include "arguments.hpp"

#include <cmath>

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

void throw_wrong_kind(const char* field, py::handle value, const char* remedy) {
  throw py::type_error(std::string(field) + " = " + shown(value) + ": " + remedy);
}

py::object index_of(const char* field, py::handle value) {
  auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (number) return number;
  if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw py::error_already_set();
  PyErr_Clear();
  throw_wrong_kind(field, value, "give a whole number");
}

double real_number(const char* field, py::handle value) {
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() == nullptr) return number;
  const bool is_too_large = PyErr_ExceptionMatches(PyExc_OverflowError) != 0;
  const bool is_none = PyErr_ExceptionMatches(PyExc_TypeError) != 0 ||
                       PyErr_ExceptionMatches(PyExc_ValueError) != 0;  // a signaling NaN
  if (!is_too_large && !is_none) throw py::error_already_set();
  PyErr_Clear();
  if (is_too_large) throw_bad_value(field, shown(value), "out of range");
  throw_wrong_kind(field, value, "give a number");
}

std::chrono::nanoseconds time_of_ms(const char* field, py::handle value) {
  constexpr double kLongestMs = 9.2e12;  // 2^63 ns
  const double ms = real_number(field, value);
  if (!(std::abs(ms) < kLongestMs)) throw_bad_value(field, shown(value), "must be a time in ms");
  return std::chrono::nanoseconds(std::llround(ms * 1e6));
}

void translate_bad_times() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(thrown);
    } catch (const BadValue& bad) {
      if (bad.unit.empty()) throw;  // the message says all
      const std::string text = bad.field + "_" + bad.unit + " = " + bad.value + ": " + bad.remedy;
      py::set_error(PyExc_ValueError, text.c_str());
    }
  });
}

}  // namespace asap::python
