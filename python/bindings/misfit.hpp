// Why a call does not fit a function's signature: the first argument that is of the wrong kind, out
// of range, missing or unknown, by name, value and remedy. Reads the text of the signature, which
// is all that pybind11 keeps of the types.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace asap::python {

// How a signature writes int.
constexpr std::string_view kWholeNumber = "typing.SupportsInt | typing.SupportsIndex";

// A call as the interpreter makes it: `count` values by position, then one for each of `names`
// (a tuple, or null).
struct Call {
  PyObject* const* values = nullptr;
  std::size_t count = 0;
  pybind11::handle names;
};

struct Misfit {
  pybind11::handle error;  // the class to raise
  std::string message;
};

// None: as far as it can tell, the call fits. An exception of an argument's own comes out
// unchanged.
std::optional<Misfit> find_misfit(std::string_view signature, const Call& call);

}  // namespace asap::python
