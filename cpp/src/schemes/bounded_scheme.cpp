#include "asap/schemes/bounded_scheme.hpp"

#include <cmath>

#include "asap/core/check.hpp"
#include "schemes/latency_bound.hpp"

namespace asap {

BoundedScheme::BoundedScheme(double latency_ms, double overhead, double min_interval_ms,
                             double knee, CostModelConfig cost)
    : latency_bound_ns_(checked_latency_ns(latency_ms)),
      hold_(overhead, min_interval_ms),
      cost_(cost) {
  require(knee == 0 || (knee >= 1 && knee <= 1e6), "knee", knee,
          "must be 0 (off) or between 1 and 1e6");
}

void BoundedScheme::reset(Execution execution) noexcept {
  cost_.reset();
  execution_ = execution;
  packages_ = 0;
}

void BoundedScheme::observe(const Outcome& outcome) noexcept {
  if (outcome.size == 0) return;  // no algorithm ran
  cost_.update(outcome);
  ++packages_;
}

Decision BoundedScheme::within(double budget_ns, Decision decision) const noexcept {
  decision.budget_ns = std::llround(budget_ns);
  decision.fixed_ns = cost_.alpha_ns();
  decision.event_ns = cost_.beta_ns();
  decision.most_event_ns = cost_.doubted_event_ns();
  return decision;
}

// The configured number itself, while that is the bound in force.
double BoundedScheme::latency_ms(double configured_ms) const noexcept {
  const std::int64_t bound_ns = latency_bound_ns_;
  if (bound_ns == std::llround(configured_ms * 1e6)) return configured_ms;
  return static_cast<double>(bound_ns) / 1e6;
}

}  // namespace asap
