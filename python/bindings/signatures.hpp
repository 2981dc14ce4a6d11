// What inspect.signature shows of a class: its constructor's arguments by name, and what repr shows
// of its objects: those that are no defaults. CPython takes arguments that open a docstring off it
// and shows them as the signature.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace asap::python {

// Shows the signature of one class. `keywords`, such as ", window=800", replace **kwargs.
void show_signature(pybind11::handle type, const std::string& keywords = ", **kwargs");

// Signature and repr for every class of the module that has a constructor; the repr where objects
// have .parameters and no repr of their own. Call it when all are bound.
void show_signatures(const pybind11::module_& m);

}  // namespace asap::python
