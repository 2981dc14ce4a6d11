#include "asap/runner/linear_cost.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "asap/core/check.hpp"

namespace asap {

LinearCost::LinearCost(LinearCostConfig config) : config_(config), random_(config.seed) {
  require(config.alpha_us >= 0 && config.alpha_us <= 1e9, "alpha_us", config.alpha_us,
          "must be between 0 and 1e9 us");
  require(config.beta_ns >= 0 && config.beta_ns <= 1e9, "beta_ns", config.beta_ns,
          "must be between 0 and 1e9 ns");
  require(config.noise >= 0 && config.noise <= 5, "noise", config.noise, "must be between 0 and 5");
}

std::int64_t LinearCost::processing_ns(std::uint64_t index, std::size_t size) const noexcept {
  const double mean_ns = config_.alpha_us * 1e3 + config_.beta_ns * static_cast<double>(size);
  const double factor = config_.noise > 0 ? noise_factor(index) : 1.0;
  return std::max<std::int64_t>(std::llround(std::min(mean_ns * factor, 9e18)), 1);
}

double LinearCost::noise_factor(std::uint64_t index) const noexcept {
  // Box-Muller.
  const double u = 1.0 - random_.uniform(2 * index);  // (0, 1]
  const double v = random_.uniform(2 * index + 1);
  const double normal = std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
  const double factor = std::exp(config_.noise * normal - 0.5 * config_.noise * config_.noise);
  // Math libraries differ in the last bit; a run must not.
  return std::nearbyint(factor * 0x1.0p24) * 0x1.0p-24;
}

}  // namespace asap
