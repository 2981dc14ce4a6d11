#include "asap/schemes/fixed.hpp"

#include <algorithm>
#include <cmath>

#include "asap/core/check.hpp"

namespace asap {
namespace {

std::int64_t checked_period_ns(double period_ms) {
  require(period_ms >= 0.001 && period_ms <= 1e9, "period_ms", period_ms,
          "must be between 0.001 (1 us) and 1e9 ms");
  return std::llround(period_ms * 1e6);
}

}  // namespace

FixedSize::FixedSize(Config config) : config_(config) {
  require(config.size >= 1 && config.size <= kLargestSize, "size", config.size,
          "must be between 1 and 2^40 events");
}

Decision FixedSize::decide(const Backlog& backlog) noexcept {
  if (backlog.count < config_.size && !backlog.due) return Decision::wait_for(config_.size);
  return Decision::take(std::min(backlog.count, config_.size));
}

FixedTime::FixedTime(Config config)
    : config_(config), period_ns_(checked_period_ns(config.period_ms)) {}

Decision FixedTime::decide(const Backlog& backlog) noexcept {
  const std::int64_t boundary_ns = (floor_div(backlog.oldest_ns, period_ns_) + 1) * period_ns_;
  if (backlog.now_ns < boundary_ns && !backlog.due) return Decision::wait_until(boundary_ns);
  return Decision::take(backlog.counts.before(boundary_ns));
}

}  // namespace asap
