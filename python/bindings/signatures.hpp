// What inspect.signature shows of a class: its constructor's arguments by name. CPython takes
// arguments that open a docstring off it and shows them as the signature.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace asap::python {

// Of one class. `keywords` stand in the place of **kwargs, such as ", window=800".
void show_signature(pybind11::handle type, const std::string& keywords = ", **kwargs");

// Of every class of the module that has a constructor: call it when all are bound.
void show_signatures(const pybind11::module_& m);

}  // namespace asap::python
