#include "study/scheduling_jitter.hpp"

namespace asap {

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
