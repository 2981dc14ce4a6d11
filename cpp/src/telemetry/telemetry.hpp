// Telemetry: what the consumer's side of a run writes down: a row per package, the latency of every
// event, and where the others went. One thread writes; any thread may copy all but the rows
// meanwhile. Rows are the consumer's until the run is over.
#pragma once

#include <cstddef>
#include <cstdint>

#include "asap/telemetry/latency_histogram.hpp"
#include "asap/telemetry/run_log.hpp"
#include "core/atomics.hpp"

namespace asap {

struct Telemetry {
  // max_rows: see RunLog.
  explicit Telemetry(std::int64_t latency_bound_ns, std::size_t max_rows = RunLog::kAllRows)
      : log(max_rows), latency(latency_bound_ns) {}

  RunLog log;
  LatencyHistogram latency;
  Relaxed<std::uint64_t> filtered;
  Relaxed<std::uint64_t> discarded;
  Relaxed<std::uint64_t> stale;
  Relaxed<std::uint64_t> overflow;  // dropped from a full ring by the consumer's side
  Relaxed<std::uint64_t> delivered;
};

}  // namespace asap
