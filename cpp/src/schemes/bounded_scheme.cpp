#include "schemes/bounded_scheme.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"
#include "schemes/calibration.hpp"

namespace asap::inline v0_1 {
namespace {

using namespace std::chrono_literals;

constexpr double kEfficientShare = 0.05;  // of the fixed cost in an efficient package
constexpr double kManyEvents = 1e15;

// Returns the number of events that justify a package at once: its fixed cost is within the
// permitted share, or it fills half the bound.
std::size_t enough(const CostModel& cost, double overhead, double caution,
                   double latency_ns) noexcept {
  const double alpha_ns = cost.alpha_ns();
  const double efficient_ns = alpha_ns / std::max(overhead, kEfficientShare) - alpha_ns;
  const double size = std::min(efficient_ns, latency_ns / 2 / caution - alpha_ns) / cost.beta_ns();
  return static_cast<std::size_t>(std::ceil(std::clamp(size, 1.0, kManyEvents)));
}

}  // namespace

std::int64_t interval_ns(const Backlog& backlog) noexcept {
  if (backlog.previous_start_ns == kLongAgo) return kNever;
  return backlog.now_ns - backlog.previous_start_ns;
}

HoldRule::HoldRule(double overhead, std::chrono::nanoseconds min_interval)
    : overhead_(overhead), min_interval_ns_(static_cast<double>(min_interval.count())) {
  require(overhead >= 0 && overhead <= 1, "overhead", overhead,
          "must be between 0 (no limit) and 1");
  require_time(min_interval >= 0s && min_interval <= 10'000s, "min_interval", min_interval,
               TimeUnit::ms, "must be between 0 and 1e7 ms");
}

double HoldRule::shortest_ns(double latency_ns) const noexcept {
  return std::min(min_interval_ns_, latency_ns / 2);
}

double HoldRule::longest_ns(const CostModel& cost, double latency_ns) const noexcept {
  const double affordable_ns =
      overhead_ > 0 ? std::min(cost.alpha_ns() / overhead_, latency_ns / 4) : 0.0;
  return std::max(affordable_ns, shortest_ns(latency_ns));
}

std::optional<Decision> HoldRule::wait(const Backlog& backlog, const CostModel& cost,
                                       double caution, double latency_ns) const noexcept {
  if (backlog.due) return std::nullopt;
  const std::int64_t shortest = std::llround(shortest_ns(latency_ns));
  const std::int64_t hold = std::llround(longest_ns(cost, latency_ns));

  const std::int64_t interval = interval_ns(backlog);
  if (interval >= hold || backlog.age_ns() >= hold) return std::nullopt;
  const std::int64_t flush_ns = backlog.oldest_ns + hold;
  if (interval < shortest) {
    return Decision::wait_until(std::min(backlog.previous_start_ns + shortest, flush_ns));
  }
  const std::size_t count = enough(cost, overhead_, caution, latency_ns);
  if (backlog.count >= count) return std::nullopt;
  Decision decision = Decision::wait_until(std::min(backlog.previous_start_ns + hold, flush_ns));
  decision.until_count = count;
  return decision;
}

bool FixedCostProbe::is_due(std::uint64_t package, double alpha_ns, double bound_ns) noexcept {
  is_measuring_ = was_late_ && !is_early(package) && package >= next_ && 4.0 * alpha_ns > bound_ns;
  return is_measuring_;
}

void FixedCostProbe::observe(std::uint64_t package, double latency_ns, double bound_ns,
                             double work_ns, double alpha_ns) noexcept {
  was_late_ = latency_ns > bound_ns;
  if (!is_measuring_) return;
  is_measuring_ = false;
  distance_ = work_ns > alpha_ns / 2 ? std::min(2 * distance_, kLongest) : kShortest;
  next_ = package + distance_;
}

BoundedScheme::BoundedScheme(std::chrono::nanoseconds latency, double overhead,
                             std::chrono::nanoseconds min_interval, CostModelConfig cost)
    : latency_bound_ns_(checked_latency_ns(latency)), hold_(overhead, min_interval), cost_(cost) {}

void BoundedScheme::reset(Execution execution) noexcept {
  cost_.reset();
  execution_ = execution;
  packages_ = 0;
  age_ns_ = 0.0;
  probe_ = {};
}

void BoundedScheme::observe(const Outcome& outcome) noexcept {
  if (outcome.size == 0) return;  // no algorithm ran
  probe_.observe(packages_, age_ns_ + static_cast<double>(outcome.processing_ns),
                 static_cast<double>(latency_bound_ns_.load()),
                 static_cast<double>(outcome.work_ns()), cost_.alpha_ns());
  cost_.update(outcome);
  ++packages_;
}

Decision BoundedScheme::within(double budget_ns, Decision decision) const noexcept {
  decision.budget_ns = std::llround(budget_ns);
  decision.fixed_ns = cost_.alpha_ns();
  decision.event_ns = cost_.beta_ns();
  decision.max_event_ns = cost_.doubted_event_ns();
  return decision;
}

}  // namespace asap::inline v0_1
