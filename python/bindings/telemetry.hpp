// What a run has counted and logged, as dicts and NumPy arrays.
#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <cstdint>
#include <span>

#include "asap/filter/validator.hpp"
#include "asap/telemetry/ledger.hpp"
#include "asap/telemetry/run_log.hpp"

namespace asap::python {

namespace py = pybind11;

// A slot as it is read.
struct SlotRow {
  std::int64_t slot;
  std::int64_t received;
  std::int64_t delivered;
  double latency_max_us;
};

// Where every event went, in events.
py::dict dict_of(const Ledger& ledger);
// Events rejected, by reason.
py::dict dict_of(const Rejections& by);

// A copy in PACKAGE_DTYPE, one row per package, of those that are kept from number `since` on.
py::array_t<PackageRow> rows_of(const RunLog& log, std::size_t since = 0);
// A copy in SLOT_DTYPE, one row per slot.
py::array_t<SlotRow> rows_of(std::span<const Slot> slots);

}  // namespace asap::python
