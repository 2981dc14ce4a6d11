// HoldRule: whether a free algorithm shall wait before the next package (notebooks/theory.md,
// section 3). Packages cost a fixed time each; waiting for alpha / overhead between two starts
// limits the share of the processor that goes into it, and `min_interval` limits the number of
// packages. Never longer than half the latency bound, and no longer than it takes to have enough
// events for an efficient package. The oldest event never waits longer either, so a quiet scene is
// flushed. Pure, O(1), no allocation.
#pragma once

#include <cstdint>
#include <optional>

#include "asap/schemes/cost_model.hpp"
#include "asap/schemes/scheme.hpp"

namespace asap {

// Since the start of the last package; kNever before the first.
std::int64_t interval_ns(const Backlog& backlog) noexcept;

class HoldRule {
 public:
  // overhead: permitted share of fixed costs, 0 = any. min_interval_ms: between package starts.
  HoldRule(double overhead, double min_interval_ms);

  // The wait, or nothing: start now. `caution` (zeta) times the predicted cost is planned with.
  std::optional<Decision> wait(const Backlog& backlog, const CostModel& cost, double caution,
                               double latency_ns) const noexcept;

  double min_interval_ns() const noexcept { return min_interval_ns_; }

  // The longest time between two package starts that is waited for.
  double longest_ns(const CostModel& cost, double latency_ns) const noexcept;

 private:
  double shortest_ns(double latency_ns) const noexcept;

  const double overhead_;
  const double min_interval_ns_;
};

}  // namespace asap
