// Consumer, WhenFull, RunConfig, PipelineMemory: what the runners have in common.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "asap/filter/front_filter.hpp"
#include "asap/filter/validator.hpp"
#include "asap/packager/package.hpp"
#include "asap/schemes/scheme.hpp"

namespace asap {

// The algorithm as a runner sees it: a callable that takes a package (or, by conversion, its
// events). Called on the consumer's thread, once per package; where the execution is anytime, once
// per part of it (package.continues from the second on).
using Consumer = std::function<void(const Package&)>;

// What gives way when live events come faster than they leave the ring.
enum class WhenFull {
  // Beyond three quarters, the more the ring fills the fewer events of a push get in, by chance:
  // the thinning stays uniform, whatever the size of a push, and counts as discarded. Only a push
  // that finds the ring full, because the consumer stands still, is overflow. See Intake.
  thin,
  newest,  // what does not fit is dropped
  oldest,  // finding the ring full, the consumer drops the older half
  block,   // the producer waits for room: only for sources that can wait, such as files
};

struct RunConfig {
  // The latency bound, such as 10ms; none: the scheme's own, else kDefaultLatency.
  std::optional<std::chrono::nanoseconds> latency{};
  // Of the ring, events; 0: 2^20 or 60 Mev/s x 2 bounds, if more. NoMemory if it cannot be had.
  std::size_t capacity = 0;
  std::uint64_t seed = 0;  // of the gamma filter
  ValidatorConfig validator{};
  // whole: the algorithm gets a package in one call. anytime: in up to 16 calls, in time order, so
  // that the package ends on time whatever an event costs; for algorithms whose call costs nothing,
  // such as this library's. A call that costs 50 us would cost 800 us per package.
  Execution execution = Execution::whole;
  bool flush =
      true;  // false, for experiments: nothing is taken because it has waited for the bound
  FrontFilter front_filter{};           // in front of the gamma filter; may be none
  WhenFull when_full = WhenFull::thin;  // the ring of a live pipeline
  bool keep_mask = false;               // of a recording: note which events were delivered
  // Rows that the log of a live pipeline keeps, the newest ones, 96 bytes each; 0: totals alone.
  std::size_t log_rows = 16'384;
  // Kept events of a package that is thinned or lies across the ring's end, 16 bytes each; what is
  // more follows as the next package. 0: 131,072 of a live pipeline, any number of a recording.
  std::size_t max_copied = 0;
  // Write to all memory in the constructor: no page of it is missing when events come.
  bool prefault = false;
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

}  // namespace asap
