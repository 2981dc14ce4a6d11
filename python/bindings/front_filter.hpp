// The filter in front of gamma, made of a Python object (before=).
#pragma once

#include <pybind11/pybind11.h>

#include "asap/packager/package.hpp"

namespace asap::python {

// One of ours runs natively, without the GIL. Any other object is called with a read-only array:
// its process(events) or, if it has none, itself; it returns the events that pass, in EVENT_DTYPE.
// None is no filter. Call with the GIL held; the filter keeps the object alive.
FrontFilter front_filter_of(const pybind11::object& filter);

}  // namespace asap::python
