// The layer `telemetry`: ledger, latency per event, rows of the packages.
#include "telemetry.hpp"

#include <pybind11/stl.h>

#include <algorithm>

#include "arguments.hpp"
#include "asap/telemetry/latency_histogram.hpp"
#include "asap/telemetry/ledger.hpp"
#include "held.hpp"

namespace asap::python::telemetry {
namespace {

using HistogramState =
    std::tuple<std::int64_t, std::int64_t, std::uint64_t, std::uint64_t, std::uint64_t,
               std::vector<std::pair<std::uint32_t, std::uint64_t>>>;

HistogramState state_of(const LatencyHistogram& histogram) {
  const LatencyHistogram::State s = histogram.state();
  return {s.bound_ns, s.max_ns, s.within_bound, s.sum_low, s.sum_high, s.bins};
}

LatencyHistogram restored(const HistogramState& state) {
  const auto& [bound_ns, max_ns, within_bound, sum_low, sum_high, bins] = state;
  return LatencyHistogram::restored({bound_ns, max_ns, within_bound, sum_low, sum_high, bins});
}

}  // namespace
}  // namespace asap::python::telemetry

namespace asap::python {

py::dict dict_of(const Ledger& ledger) {
  using namespace py::literals;
  return py::dict("received"_a = ledger.received, "rejected"_a = ledger.rejected,
                  "filtered"_a = ledger.filtered, "discarded"_a = ledger.discarded,
                  "stale"_a = ledger.stale, "overflow"_a = ledger.overflow,
                  "delivered"_a = ledger.delivered, "pending"_a = ledger.pending);
}

py::dict dict_of(const Rejections& by) {
  using namespace py::literals;
  return py::dict("nonmonotonic"_a = by.nonmonotonic, "out_of_bounds"_a = by.out_of_bounds,
                  "bad_polarity"_a = by.bad_polarity, "bad_record"_a = by.bad_record,
                  "before_start"_a = by.before_start);
}

py::array_t<PackageRow> rows_of(const RunLog& log, std::size_t since) {
  const std::size_t first = std::clamp(since, log.first(), log.size());
  py::array_t<PackageRow> rows(static_cast<py::ssize_t>(log.size() - first));
  PackageRow* out = rows.mutable_data();
  for (std::size_t i = first; i < log.size(); ++i) *out++ = log[i];
  rows.attr("flags").attr("writeable") = false;
  return rows;
}

py::array_t<SlotRow> rows_of(std::span<const Slot> slots) {
  py::array_t<SlotRow> rows(static_cast<py::ssize_t>(slots.size()));
  SlotRow* out = rows.mutable_data();
  for (const Slot& slot : slots) {
    *out++ = {slot.slot, slot.received, slot.delivered,
              static_cast<double>(slot.latency_max_ns) * 1e-3};
  }
  rows.attr("flags").attr("writeable") = false;
  return rows;
}

}  // namespace asap::python

namespace asap::python::telemetry {

void bind(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(PackageRow, index, start_us, processing_us, t_first, t_last, offered, size,
                       gamma, event_rate, rate, margin_us, latency_max_us, stale, overflow);
  m.attr("PACKAGE_DTYPE") = py::dtype::of<PackageRow>();
  PYBIND11_NUMPY_DTYPE(SlotRow, slot, received, delivered, latency_max_us);
  m.attr("SLOT_DTYPE") = py::dtype::of<SlotRow>();

  Class<LatencyHistogram>(m, "LatencyHistogram", R"(Latency per delivered event, in us.

Fixed memory; a quantile is within 0.4 %, the rest is exact. Made of the `state()` of another.
)")
      .def(py::init(&restored), py::arg("state"))
      .def(
          "__repr__",
          [](const LatencyHistogram& h) {
            return py::str(
                       "<LatencyHistogram: {} events, p50 {:.4g} us, p99 {:.4g} us, max {:.4g} us>")
                .format(h.count(), h.quantile_ns(0.5) * 1e-3, h.quantile_ns(0.99) * 1e-3,
                        static_cast<double>(h.max_ns()) * 1e-3);
          })
      .def_property_readonly("count", &LatencyHistogram::count, "Events delivered.")
      .def_property_readonly(
          "mean", [](const LatencyHistogram& h) { return h.mean_ns() * 1e-3; }, "us")
      .def_property_readonly(
          "max", [](const LatencyHistogram& h) { return static_cast<double>(h.max_ns()) * 1e-3; },
          "us")
      .def_property_readonly("within_bound", &LatencyHistogram::within_bound,
                             "Events delivered within the latency bound.")
      .def(
          "quantile", [](const LatencyHistogram& h, double q) { return h.quantile_ns(q) * 1e-3; },
          py::arg("q"),
          R"(The latency in us that the fraction q of the delivered events does not exceed.

Raises
------
ValueError
    q is NaN or outside [0, 1].
)")
      .def("state", &state_of, "All that is recorded, as plain numbers.")
      .def("__reduce__", [](const py::object& self) {
        return py::make_tuple(py::type::of<LatencyHistogram>(),
                              py::make_tuple(self.attr("state")()));
      });
}

}  // namespace asap::python::telemetry
