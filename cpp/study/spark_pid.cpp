#include "study/spark_pid.hpp"

#include <algorithm>
#include <limits>

namespace asap {
namespace {

constexpr double kSparkIntegral = 0.2;
constexpr double kSparkLeastShare = 0.05;  // of v
constexpr double kLeastEvents = 1.0;       // or no package would tell what the algorithm achieves

}  // namespace

SparkPid::SparkPid(double latency_ms) : Rival(latency_ms), period_ns_(latency_ns_ / 2) {}

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
