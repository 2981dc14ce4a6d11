// BoundedScheme: what DeadBeat and Deadline share: the latency bound in force, the wait before a
// package (HoldRule), the learned cost of a package and how often it was measured. The law itself
// is theirs.
//
// Called on the consumer's thread; any thread may read and set the bound. O(1), no allocation.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "asap/core/atomics.hpp"
#include "asap/schemes/cost_model.hpp"
#include "asap/schemes/scheme.hpp"

namespace asap {

// Since the start of the last package; kNever before the first.
std::int64_t interval_ns(const Backlog& backlog) noexcept;

// Whether a free algorithm shall wait before the next package (notebooks/theory.md, section 3).
// Packages cost a fixed time each; waiting for alpha / overhead between two starts limits the share
// of the processor that goes into it, and `min_interval` limits the number of packages. Never
// longer than half the latency bound, and no longer than it takes to have enough events for an
// efficient package. The oldest event never waits longer either, so a quiet scene is flushed. Pure.
class HoldRule {
 public:
  // overhead: permitted share of fixed costs, 0 = any. min_interval: between package starts.
  HoldRule(double overhead, std::chrono::nanoseconds min_interval);

  // The wait, or nothing: start now. `caution` (zeta) times the predicted cost is planned with.
  std::optional<Decision> wait(const Backlog& backlog, const CostModel& cost, double caution,
                               double latency_ns) const noexcept;

  // The shortest time between two package starts: min_interval, but never more than half the bound.
  double shortest_ns(double latency_ns) const noexcept;
  // The longest time between two package starts that is waited for.
  double longest_ns(const CostModel& cost, double latency_ns) const noexcept;

 private:
  const double overhead_;
  const double min_interval_ns_;
};

// Decides when a package of one event measures the fixed cost: where packages end late and the
// estimate blames the fixed cost. Each probe that confirms it doubles the distance to the next one,
// so 1 in 16 to 1 in 16,384 packages are probes.
class FixedCostProbe {
 public:
  bool is_due(std::uint64_t package, double alpha_ns, double bound_ns) noexcept;
  // That package has ended: the age of its oldest event, the time of its work, and the fixed cost
  // that was believed before.
  void observe(std::uint64_t package, double latency_ns, double bound_ns, double work_ns,
               double alpha_ns) noexcept;

 private:
  static constexpr std::uint64_t kShortest = 16;  // packages
  static constexpr std::uint64_t kLongest = 16'384;

  std::uint64_t next_ = 0;
  std::uint64_t distance_ = kShortest;
  bool was_late_ = false;
  bool is_measuring_ = false;
};

class BoundedScheme : public Scheme {
 public:
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::int64_t latency_bound_ns() const noexcept final { return latency_bound_ns_; }
  void set_latency_bound_ns(std::int64_t bound_ns) noexcept final { latency_bound_ns_ = bound_ns; }

  // What a package costs, as far as it is known.
  double alpha_ns() const noexcept { return cost_.alpha_ns(); }
  double beta_ns() const noexcept { return cost_.beta_ns(); }

 protected:
  // The configuration has latency, overhead and min_interval, which are checked here.
  template <class Config>
  explicit BoundedScheme(const Config& config, CostModelConfig cost = {})
      : BoundedScheme(config.latency, config.overhead, config.min_interval, cost) {}

  // The configuration's parameters, with the bound in force.
  template <class Config>
  SchemeParameters parameters_in_force(Config config) const {
    config.latency = std::chrono::nanoseconds(latency_bound_ns_);
    return parameters_of(config);
  }

  bool is_whole() const noexcept { return execution_ == Execution::whole; }
  // The decision of an anytime package, which is to end budget_ns after its start.
  Decision within(double budget_ns, Decision decision) const noexcept;

  Relaxed<std::int64_t> latency_bound_ns_;
  const HoldRule hold_;
  CostModel cost_;
  Execution execution_ = Execution::whole;
  std::uint64_t packages_ = 0;  // k, done
  double age_ns_ = 0.0;         // age of the oldest event in the last package decided
  FixedCostProbe probe_;

 private:
  BoundedScheme(std::chrono::nanoseconds latency, double overhead,
                std::chrono::nanoseconds min_interval, CostModelConfig cost);
};

}  // namespace asap
