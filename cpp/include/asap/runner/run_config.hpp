// Consumer, WhenFull, RunConfig, RunStats, PipelineMemory, of all runners: plain data, any thread.
//
//   const RunConfig config{.latency = 10ms, .validator = {.width = 346, .height = 260}};
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "asap/filter/validator.hpp"
#include "asap/packager/package.hpp"
#include "asap/schemes/scheme.hpp"
#include "asap/telemetry/latency_histogram.hpp"
#include "asap/telemetry/ledger.hpp"
#include "asap/telemetry/run_log.hpp"

namespace asap::inline v0_1 {

// The algorithm as a runner sees it: a callable that takes a package (or, by conversion, its
// events). Called on the consumer's thread, once per package; where the execution is anytime, once
// per part of it (package.continues from the second on).
using Consumer = std::function<void(const Package&)>;

// What happens to live events when they come faster than the consumer takes them.
enum class WhenFull {
  // A ring that is more than three quarters full takes a random part of each push: the fuller it
  // is, the smaller the part. The rest counts as discarded. Events overflow only if the ring is
  // full, which it becomes when the consumer stands still.
  thin,
  keep_oldest,  // what does not fit is dropped
  keep_newest,  // finding the ring full, the consumer drops the older half
  block,        // the producer waits for room: only for sources that can wait, such as files
};

struct RunConfig {
  // The latency bound, such as 10ms; none: the scheme's own, else kDefaultLatency.
  std::optional<std::chrono::nanoseconds> latency{};
  // The ring's capacity in events. 0 means max(2^20, two bounds at 60 Mev/s). Throws NoMemory.
  std::size_t capacity = 0;
  std::uint64_t seed = 0;  // seeds the gamma filter
  ValidatorConfig validator{};
  // whole: the algorithm gets a package in one call. anytime: it gets the package in up to 16
  // calls, in time order, so that the package ends on time whatever an event costs. Choose anytime
  // where a call costs next to nothing, as with this library's algorithms: 16 calls of 50 us cost
  // 800 us.
  Execution execution = Execution::whole;
  // An event that has waited for the latency bound is due, whatever the scheme waits for. false,
  // for experiments: the scheme alone decides.
  bool flush = true;
  FrontFilter front_filter{};           // runs before the gamma filter; may be none
  WhenFull when_full = WhenFull::thin;  // the ring of a live pipeline
  bool keep_mask = false;               // recordings only: note which events were delivered
  // How many rows the log of a live pipeline keeps: the newest, 96 bytes each. 0 keeps totals
  // alone.
  std::size_t log_rows = 16'384;
  // The largest package, in events of 16 bytes, that is copied because it is thinned or lies across
  // the ring's end. What is more follows as the next package. 0 means 131,072 in a live pipeline
  // and no limit for a recording.
  std::size_t max_copied = 0;
  // Whether the constructor writes to all memory, so that no page fault happens later.
  bool prefault = false;
  // The worker calls it before its first package, in every run: for its name, its processor, its
  // priority. May be none. What it throws ends the run and comes out of join().
  std::function<void()> on_worker_start{};
};

// What a run has come to: a snapshot. What happened between two of one run: `later.ledger -
// earlier.ledger`, `later.latency.since(earlier.latency)`. Of a pipeline that was started again
// between them (PipelineStats::run), all of the later one happened since.
struct RunStats {
  Ledger ledger{};
  Rejections rejected{};
  LatencyHistogram latency{};  // per delivered event, to the end of its package
  PackageTotals packages{};
  // The longest time between two delivered events in a row with a loss between, us: of wall time in
  // a replay, else of timestamps.
  std::int64_t gap_us = 0;
  std::uint64_t clock_resets = 0;
  bool failed = false;  // the run has ended by an exception of the algorithm, the source or a poll
};

// Bytes that a pipeline with a worker takes from the heap, all of them in its constructor.
struct PipelineMemory {
  std::size_t ring;    // RunConfig::capacity
  std::size_t copies;  // RunConfig::max_copied
  std::size_t log;     // RunConfig::log_rows
  std::size_t rest;    // tables of arrival times, the latency histogram, the scheme, scratch

  std::size_t total() const noexcept { return ring + copies + log + rest; }
};

// The bound in force. Throws std::invalid_argument for a value out of range, and when the scheme
// has another bound of its own.
std::int64_t latency_bound_ns(const RunConfig& config, const Scheme& scheme);

// The ring's capacity in force.
std::size_t ring_capacity(const RunConfig& config, std::int64_t latency_bound_ns) noexcept;

}  // namespace asap::inline v0_1
