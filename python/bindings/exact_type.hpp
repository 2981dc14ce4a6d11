// Whether an object's loop may be ours. A class derived in Python is not ours: it may have a
// process of its own.
#pragma once

#include <pybind11/pybind11.h>

namespace asap::python {

template <class Algorithm>
bool is_exactly(const pybind11::object& object) {
  return pybind11::type::of(object).is(pybind11::type::of<Algorithm>());
}

}  // namespace asap::python
