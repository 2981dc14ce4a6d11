// Arguments from Python that pybind11 would refuse with a list of signatures or take with a loss:
// refused by field, value and remedy, as everywhere.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <string>

namespace asap::python {

// Any object with __index__; TypeError for others, ValueError unless 0 <= value < 2**64.
std::uint64_t whole_number(const char* field, const pybind11::object& value);

// How a message shows a value: its repr, cut short. Whatever the repr does, there is a text.
std::string shown(pybind11::handle value);

}  // namespace asap::python
