#include "study/realtime.hpp"

#include "core/check.hpp"

namespace asap {

BusyWait::BusyWait(BusyWaitConfig config) : config_(config) {
  require(config.alpha_us >= 0 && config.alpha_us <= 1e6, "alpha_us", config.alpha_us,
          "must be between 0 and 1e6 us");
  require(config.beta_ns >= 0 && config.beta_ns <= 1e6, "beta_ns", config.beta_ns,
          "must be between 0 and 1e6 ns");
}

LatencyHistogram scheduling_jitter(std::chrono::nanoseconds duration) {
  using Clock = std::chrono::steady_clock;
  LatencyHistogram gaps;
  auto before = Clock::now();
  const auto end = before + duration;
  while (before < end) {
    const auto now = Clock::now();
    gaps.record(std::chrono::nanoseconds(now - before).count());
    before = now;
  }
  return gaps;
}

}  // namespace asap
