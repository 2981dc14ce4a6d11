#include "study/greedy_rate_gamma.hpp"

#include <algorithm>

namespace asap {
namespace {

constexpr double kNewShare = 0.006379563620851;  // 1 - exp(-32 us / 5 ms)
constexpr double kLeastShare = 0.05;             // of 1/beta

}  // namespace

void GreedyRateGamma::observe(const Outcome& outcome) noexcept { cost_.update(outcome); }

double GreedyRateGamma::gamma(const Arrivals& arrivals) noexcept {
  const double rate = static_cast<double>(arrivals.arrived) / static_cast<double>(period_ns());
  rate_ += kNewShare * (rate - rate_);
  const double overhead = 2.0 * cost_.alpha_ns() / static_cast<double>(latency_ns_);
  const double able = std::max(1.0 - overhead, kLeastShare) / cost_.beta_ns();
  return rate_ > able ? able / rate_ : 1.0;
}

void GreedyRateGamma::reset(Execution) noexcept {
  cost_.reset();
  rate_ = 0.0;
}

}  // namespace asap
