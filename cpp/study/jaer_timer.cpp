#include "study/jaer_timer.hpp"

#include <algorithm>
#include <utility>

namespace asap {

JaerTimer::JaerTimer(double latency_ms, LinearCost cost)
    : Rival(latency_ms), cost_(std::move(cost)) {}

Decision JaerTimer::decide(const Backlog& backlog) noexcept {
  if (rest_ > 0) return Decision::drop(std::exchange(rest_, 0));
  waited_ = backlog.count;
  const PackageCost cost = cost_.package(packages_, backlog.now_ns);
  const double timer_ns = 0.5 * static_cast<double>(latency_ns_);
  if (cost.of(backlog.count) <= timer_ns) return Decision::take(backlog.count);
  const double events = (timer_ns - cost.fixed_ns) / cost.event_ns;  // < count
  return Decision::take(events > 1 ? static_cast<std::size_t>(events) : 1);
}

void JaerTimer::observe(const Outcome& outcome) noexcept {
  if (outcome.size > 0) ++packages_;
  rest_ = waited_ - std::min(outcome.raw, waited_);
}

void JaerTimer::reset(Execution) noexcept {
  packages_ = 0;
  waited_ = 0;
  rest_ = 0;
}

}  // namespace asap
