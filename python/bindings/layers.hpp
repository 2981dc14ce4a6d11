// How the layers are bound, each in the file of its name. Algorithms bind themselves: see
// native_algorithm.hpp.
#pragma once

#include <pybind11/pybind11.h>

// clang-format off
namespace asap::python::filter { void bind(pybind11::module_& m); }
namespace asap::python::validator { void bind(pybind11::module_& m); }
namespace asap::python::schemes { void bind(pybind11::module_& m); }
namespace asap::python::telemetry { void bind(pybind11::module_& m); }
namespace asap::python::runner { void bind(pybind11::module_& m); }
namespace asap::python::pipeline { void bind(pybind11::module_& m); }
namespace asap::python::oracle { void bind(pybind11::module_& m); }
namespace asap::python::formats { void bind(pybind11::module_& m); }
namespace asap::python::columns { void bind(pybind11::module_& m); }
namespace asap::python::decoders { void bind(pybind11::module_& m); }
namespace asap::python::synthetic { void bind(pybind11::module_& m); }
// clang-format on
