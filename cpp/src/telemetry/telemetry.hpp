// Telemetry: what the consumer's side of a run writes down: a row per package, the latency of every
// event, and where the others went. One thread books, in steps; any thread may copy all but the
// rows as it is between two steps. Rows are the consumer's until the run is over.
//
// A reader looks at the number of steps before and after it copies: odd or changed, it tries again.
// Where steps are shorter than a copy it would try for ever, so it asks the writer, who copies for
// it after the step: the writer never waits, and whatever it does, a copy ends. No allocation.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "asap/telemetry/latency_histogram.hpp"
#include "asap/telemetry/ledger.hpp"
#include "asap/telemetry/run_log.hpp"
#include "core/atomics.hpp"

namespace asap::inline v0_1 {

struct Telemetry {
  // max_rows: see RunLog.
  explicit Telemetry(std::int64_t latency_bound_ns, std::size_t max_rows = RunLog::kAllRows)
      : log(max_rows), latency(latency_bound_ns) {}

  // Nothing is booked, as after construction. No other thread looks.
  void reset(std::int64_t latency_bound_ns) noexcept;

  // The writer: all that `step` books is seen at once.
  template <class Step>
  void book(const Step& step) noexcept {
    const std::uint64_t before = steps_.load(std::memory_order_relaxed);
    steps_.store(before + 1, std::memory_order_relaxed);
    fence(std::memory_order_release);
    step();
    steps_.store(before + 2, std::memory_order_release);
    if (asked_.load(std::memory_order_relaxed) != nullptr) answer();
  }

  // Any thread. The ledger's terms that are booked here, the others 0.
  Ledger ledger() const noexcept;
  // Any thread. All of one moment.
  void copy_to(Ledger& ledger, LatencyHistogram& latency, PackageTotals& packages) const noexcept;

  RunLog log;
  LatencyHistogram latency;
  Relaxed<std::uint64_t> filtered;
  Relaxed<std::uint64_t> discarded;
  Relaxed<std::uint64_t> stale;
  Relaxed<std::uint64_t> overflow;  // dropped from a full ring by the consumer's side
  Relaxed<std::uint64_t> delivered;

 private:
  // What a reader asks the writer for.
  struct Copy {
    Ledger& ledger;
    LatencyHistogram& latency;
    PackageTotals& packages;
    std::atomic<bool> is_made{false};
  };
  void make(Copy& copy) const noexcept;
  bool try_make(Copy& copy) const noexcept;
  void answer() noexcept;

  std::atomic<std::uint64_t> steps_{0};  // twice; odd: one is under way
  mutable std::atomic<Copy*> asked_{nullptr};
};

}  // namespace asap::inline v0_1
