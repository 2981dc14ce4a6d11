// Normal to the eye, the same bits everywhere.
#pragma once

#include <cstdint>

#include "asap/core/random.hpp"

namespace asap::synthetic {

// The sum of twelve uniforms, of mean 0 and variance 1, exact in integers.
inline double near_normal(const CounterRandom& random, std::uint64_t number) noexcept {
  constexpr double kMean = 6.0 - 12 * 0x1.0p-17;
  std::uint64_t sum = 0;
  for (std::uint64_t draw = 3 * number; draw < 3 * number + 3; ++draw) {
    const std::uint64_t bits = random(draw);
    for (int lane = 0; lane < 64; lane += 16) sum += bits >> lane & 0xffffU;
  }
  return static_cast<double>(sum) * 0x1.0p-16 - kMean;
}

}  // namespace asap::synthetic
