// Rows of a run's log as a NumPy array.
#pragma once

#include <pybind11/numpy.h>

#include "asap/telemetry/run_log.hpp"

namespace asap::python {

namespace py = pybind11;

// A copy in PACKAGE_DTYPE, one row per package.
py::array_t<PackageRow> rows_of(const RunLog& log);

}  // namespace asap::python
