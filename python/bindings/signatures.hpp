// What inspect.signature shows of a class: its constructor's arguments by name. CPython takes
// arguments that open a docstring off it and shows them as the signature.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace asap::python {

// Shows the signature of one class. `keywords`, such as ", window=800", replace **kwargs.
void show_signature(pybind11::handle type, const std::string& keywords = ", **kwargs");

// The same for every class of the module that has a constructor. Call it when all are bound.
void show_signatures(const pybind11::module_& m);

}  // namespace asap::python
