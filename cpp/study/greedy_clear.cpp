#include "study/greedy_clear.hpp"

namespace asap {
namespace {

constexpr std::int64_t kFreshNs = 4000;  // less than half of any bound

}  // namespace

Decision GreedyClear::decide(const Backlog& backlog) noexcept {
  if (backlog.age_ns() > latency_ns_ / 2) {
    return Decision::drop(backlog.counts.before(backlog.now_ns - kFreshNs));
  }
  return Decision::take(backlog.count);
}

}  // namespace asap
