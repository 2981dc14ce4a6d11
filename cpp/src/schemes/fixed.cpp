#include "asap/schemes/fixed.hpp"

#include <algorithm>
#include <chrono>

#include "core/check.hpp"

namespace asap::inline v0_1 {
FixedSize::FixedSize(Config config) : config_(config) {
  require(config.size >= 1 && config.size <= kLargestSize, "size", config.size,
          "must be between 1 and 2^40 events");
}

Decision FixedSize::decide(const Backlog& backlog) noexcept {
  if (backlog.count < config_.size && !backlog.due) return Decision::wait_for(config_.size);
  return Decision::take(std::min(backlog.count, config_.size));
}

FixedTime::FixedTime(Config config) : config_(config) {
  using namespace std::chrono_literals;
  require_time(config.period >= 1us && config.period <= 1'000'000s, "period", config.period,
               TimeUnit::ms, "must be between 0.001 (1 us) and 1e9 ms");
}

Decision FixedTime::decide(const Backlog& backlog) noexcept {
  const std::int64_t period_ns = config_.period.count();
  const std::int64_t boundary_ns = (floor_div(backlog.oldest_ns, period_ns) + 1) * period_ns;
  if (backlog.now_ns < boundary_ns && !backlog.due) return Decision::wait_until(boundary_ns);
  return Decision::take(backlog.counts.before(boundary_ns));
}

}  // namespace asap::inline v0_1
