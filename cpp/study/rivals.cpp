#include "study/rivals.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace asap {

// ---- GreedyClear ----

namespace {

constexpr std::int64_t kFreshNs = 4000;  // less than half of any bound

}  // namespace

Decision GreedyClear::decide(const Backlog& backlog) noexcept {
  if (backlog.age_ns() > latency_ns_ / 2) {
    return Decision::drop(backlog.counts.before(backlog.now_ns - kFreshNs));
  }
  return Decision::take(backlog.count);
}

// ---- JaerTimer ----

JaerTimer::JaerTimer(std::chrono::nanoseconds latency, LinearCost cost)
    : Rival(latency), cost_(std::move(cost)) {}

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

// ---- SparkPid ----

namespace {

constexpr double kSparkIntegral = 0.2;
constexpr double kSparkLeastShare = 0.05;  // of v
constexpr double kLeastEvents = 1.0;       // or no package would tell what the algorithm achieves

}  // namespace

SparkPid::SparkPid(std::chrono::nanoseconds latency)
    : Rival(latency), period_ns_(latency_ns_ / 2) {}

Decision SparkPid::decide(const Backlog& backlog) noexcept {
  const std::int64_t close_ns = close_after(backlog.oldest_ns);
  if (backlog.now_ns < close_ns && !backlog.due) return Decision::wait_until(close_ns);
  close_ns_ = close_ns;
  const std::size_t raw = backlog.counts.before(close_ns);
  const double most = most_events(close_ns);
  const auto batch = static_cast<double>(raw);
  return Decision::take(raw, most < batch ? most / batch : 1.0);
}

void SparkPid::observe(const Outcome& outcome) noexcept {
  if (outcome.size == 0 || outcome.processing_ns <= 0) return;
  const auto processing_ns = static_cast<double>(outcome.processing_ns);
  const double v = static_cast<double>(outcome.size) / processing_ns;
  double q = v;
  if (limit_count_ > 0) {
    const auto wait_ns =
        static_cast<double>(std::max<std::int64_t>(outcome.start_ns - close_ns_, 0));
    q = v - kSparkIntegral * wait_ns * v / static_cast<double>(period_ns_);
  }
  limits_[limit_count_ % kLimits] = {.since_ns = outcome.start_ns + outcome.processing_ns,
                                     .events_per_ns = std::max(q, kSparkLeastShare * v)};
  ++limit_count_;
}

void SparkPid::reset(Execution) noexcept { limit_count_ = 0; }

// The next multiple of T.
std::int64_t SparkPid::close_after(std::int64_t time_ns) const noexcept {
  return (floor_div(time_ns, period_ns_) + 1) * period_ns_;
}

double SparkPid::most_events(std::int64_t close_ns) const noexcept {
  const std::uint64_t known = std::min<std::uint64_t>(limit_count_, kLimits);
  for (std::uint64_t back = 1; back <= known; ++back) {
    const Limit& limit = limits_[(limit_count_ - back) % kLimits];
    if (limit.since_ns <= close_ns || back == kLimits) {
      return std::max(limit.events_per_ns * static_cast<double>(period_ns_), kLeastEvents);
    }
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace asap
