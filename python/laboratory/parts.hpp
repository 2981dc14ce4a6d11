// The bind functions of the laboratory's extension.
#pragma once

#include <pybind11/pybind11.h>

namespace asap::python {

void bind_arrivals(pybind11::module_& m);
void bind_clairvoyant(pybind11::module_& m);
void bind_rivals(pybind11::module_& m);
void bind_scenes(pybind11::module_& m);

}  // namespace asap::python
