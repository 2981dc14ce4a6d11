// What the validator has counted, as Python sees it.
#pragma once

#include <pybind11/pybind11.h>

#include "asap/filter/validator.hpp"

namespace asap::python {

namespace py = pybind11;

// Events rejected, by reason.
py::dict dict_of(const Rejections& by);

}  // namespace asap::python
