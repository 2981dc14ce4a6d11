#include "study/greedy_pie.hpp"

#include <algorithm>

namespace asap {
namespace {

constexpr double kIntegral = 20;       // per s
constexpr double kProportional = 200;  // per s
constexpr double kQuietAges_s = 0.2e-3;
constexpr double kMostDropped = 0.99;

}  // namespace

double GreedyPie::gamma(const Arrivals& arrivals) noexcept {
  const double age_s = static_cast<double>(arrivals.now_ns - arrivals.oldest_ns) * 1e-9;
  const double target_s = 0.5e-9 * static_cast<double>(latency_ns_);
  drop_ += kIntegral * (age_s - target_s);
  if (age_s + age_s_ > kQuietAges_s) drop_ += kProportional * (age_s - age_s_);
  drop_ = std::clamp(drop_, 0.0, kMostDropped);
  age_s_ = age_s;
  return 1.0 - drop_;
}

void GreedyPie::reset(Execution) noexcept {
  drop_ = 0.0;
  age_s_ = 0.0;
}

}  // namespace asap
