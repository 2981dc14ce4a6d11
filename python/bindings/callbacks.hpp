// What a runner calls per package, made of a Python object: the algorithm, and the filter in front
// of gamma (before=).
#pragma once

#include <pybind11/pybind11.h>

#include "asap/packager/package.hpp"
#include "asap/runner/run_config.hpp"
#include "package_arrays.hpp"

namespace asap::python {

// One of ours runs natively, without the GIL. Any other object is called with a read-only array:
// its process(events) or, if it has none, itself; set_gamma(gamma) before it, if it has one. None
// is an empty consumer. Call with the GIL held; the consumer keeps the object alive.
Consumer consumer_of(const pybind11::object& algorithm, PackageArrays arrays = {});

// One of ours runs natively, without the GIL. Any other object is called with a read-only array:
// its process(events) or, if it has none, itself; it returns the events that pass, in EVENT_DTYPE.
// None is no filter. Call with the GIL held; the filter keeps the object alive.
FrontFilter front_filter_of(const pybind11::object& filter);

// Whether the library owns the algorithm's loop over the events: then it runs without the GIL, and
// anytime.
bool is_native(const pybind11::object& algorithm);

}  // namespace asap::python
