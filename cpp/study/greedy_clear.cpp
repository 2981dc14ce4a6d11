#include "study/greedy_clear.hpp"

#include "schemes/latency_bound.hpp"

namespace asap {
namespace {

constexpr std::int64_t kFreshNs = 4000;  // less than half of any bound

}  // namespace

GreedyClear::GreedyClear(double latency_ms)
    : latency_ms_(latency_ms), latency_ns_(checked_latency_ns(latency_ms)) {}

Decision GreedyClear::decide(const Backlog& backlog) noexcept {
  if (backlog.age_ns() > latency_ns_ / 2) {
    return Decision::drop(backlog.counts.before(backlog.now_ns - kFreshNs));
  }
  return Decision::take(backlog.count);
}

}  // namespace asap
