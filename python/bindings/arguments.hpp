// Arguments from Python that pybind11 would take with a loss or refuse without the field's name:
// refused by field, value and remedy, as everywhere.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>

#include "core/check.hpp"

namespace asap::python {

// How a message shows a value: its repr, cut short. Whatever the repr does, there is a text.
std::string shown(pybind11::handle value);

// "field = value: remedy" as a TypeError.
[[noreturn]] void throw_wrong_kind(const char* field, pybind11::handle value, const char* remedy);

// The value's __index__; TypeError where it has none.
pybind11::object index_of(const char* field, pybind11::handle value);

// The value's __float__; TypeError where it has none, ValueError beyond every double.
double real_number(const char* field, pybind11::handle value);

// A time that Python gives as a number of ms; ValueError for one that is none.
std::chrono::nanoseconds time_of_ms(const char* field, pybind11::handle value);

// As Python writes a time: a number of ms.
inline double ms_of(std::chrono::nanoseconds time) {
  return static_cast<double>(time.count()) / 1e6;
}

// What C++ says of a time, "latency = -1 ms: ...", in Python's names: "latency_ms = -1: ...".
void translate_bad_times();

// ValueError unless min <= value <= max.
template <class Whole = std::uint64_t>
Whole whole_number(const char* field, pybind11::handle value,
                   Whole min = std::numeric_limits<Whole>::min(),
                   Whole max = std::numeric_limits<Whole>::max()) {
  const pybind11::object number = index_of(field, value);
  if (number < pybind11::int_(min) || number > pybind11::int_(max)) {
    throw_bad_value(field, shown(number),
                    "must be " + std::to_string(min) + " to " + std::to_string(max));
  }
  return number.cast<Whole>();
}

}  // namespace asap::python
