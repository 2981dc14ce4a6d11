// LinearCost: a simulated algorithm. A package of n events costs X (alpha + beta n), where X is
// lognormal of mean 1 and sigma = noise, one draw per package, keyed by (seed, package index):
// repeatable.
#pragma once

#include <cstddef>
#include <cstdint>

#include "asap/core/random.hpp"

namespace asap {

struct LinearCostConfig {
  double alpha_us = 100.0;  // per package
  double beta_ns = 300.0;   // per event
  double noise = 0.0;       // sigma of the logarithm
  std::uint64_t seed = 0;
};

class LinearCost {
 public:
  explicit LinearCost(LinearCostConfig config = {});

  // Processing time of package number `index` with `size` events, at least 1 ns.
  std::int64_t processing_ns(std::uint64_t index, std::size_t size) const noexcept;

  const LinearCostConfig& config() const noexcept { return config_; }

 private:
  double noise_factor(std::uint64_t index) const noexcept;

  LinearCostConfig config_;
  CounterRandom random_;
};

}  // namespace asap
