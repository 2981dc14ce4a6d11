// What Python hears of a call that cannot be made: an exception that names the argument, its value
// and the remedy, in place of pybind11's list of signatures; and an object whose __init__ was never
// called is refused, where pybind11 would hand out memory that nobody has filled. A call of an
// object that another thread works with waits for its turn (turns.hpp).
#pragma once

#include <pybind11/pybind11.h>

namespace asap::python {

// For every function and class of the module: call it when all are bound.
void refuse_in_words(const pybind11::module_& m);

}  // namespace asap::python
