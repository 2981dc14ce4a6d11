#include "asap/schemes/greedy.hpp"

#include <algorithm>

#include "asap/core/check.hpp"

namespace asap {

Greedy::Greedy(Config config) : config_(config) {
  const double efficiency = config.efficiency.value_or(0.5);
  require(efficiency > 0 && efficiency < 1, "efficiency", efficiency,
          "must lie between 0 and 1, or be left out for no cap");
}

Decision Greedy::decide(const Backlog& backlog) noexcept {
  if (!config_.efficiency) return Decision::take(backlog.count);
  const double eta = *config_.efficiency;
  const double cap = eta / (1.0 - eta) * cost_.alpha_ns() / cost_.beta_ns();
  if (cap >= static_cast<double>(backlog.count)) return Decision::take(backlog.count);
  return Decision::take(std::max<std::size_t>(static_cast<std::size_t>(cap), 1));
}

void Greedy::observe(const Outcome& outcome) noexcept { cost_.update(outcome); }

void Greedy::reset(Execution) noexcept { cost_.reset(); }

}  // namespace asap
