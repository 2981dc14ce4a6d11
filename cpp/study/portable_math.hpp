// Mathematics with the same bits on every platform, from + - * / alone: C libraries differ in the
// last one. exp, log, and random numbers of a normal and of a Poisson distribution. Any thread but
// for PoissonTable; no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/random.hpp"

namespace asap::inline v0_1::synthetic {

// Holds for |x| up to 700; relative error below 1e-15.
inline double portable_exp(double x) noexcept {
  constexpr double kLog2E = 1.4426950408889634;
  constexpr double kLn2High = 6.93147180369123816490e-01;  // few bits: its multiples are exact
  constexpr double kLn2Low = 1.90821492927058770002e-10;
  constexpr int kTerms = 14;
  const auto doublings = static_cast<int>(x * kLog2E + (x < 0.0 ? -0.5 : 0.5));
  const double rest = (x - doublings * kLn2High) - doublings * kLn2Low;
  double sum = 1.0;
  for (int term = kTerms; term > 0; --term) sum = 1.0 + sum * rest / term;
  return std::ldexp(sum, doublings);
}

// Holds for x > 0; error below 1e-10.
inline double portable_log(double x) noexcept {
  constexpr double kLn2 = 0.69314718055994531;
  constexpr double kHalfRoot = 0.70710678118654752;
  int doublings = 0;
  double mantissa = std::frexp(x, &doublings);  // lies in [0.5, 1)
  if (mantissa < kHalfRoot) {
    mantissa *= 2.0;
    --doublings;
  }
  // log m = 2 artanh((m - 1) / (m + 1)), of an argument within 0.172.
  const double ratio = (mantissa - 1.0) / (mantissa + 1.0);
  const double square = ratio * ratio;
  double sum = 1.0 / 11.0;
  sum = sum * square + 1.0 / 9.0;
  sum = sum * square + 1.0 / 7.0;
  sum = sum * square + 1.0 / 5.0;
  sum = sum * square + 1.0 / 3.0;
  sum = sum * square + 1.0;
  return doublings * kLn2 + 2.0 * ratio * sum;
}

// Normal to the eye: the sum of twelve uniforms, of mean 0 and variance 1, exact in integers.
inline double near_normal(const CounterRandom& random, std::uint64_t number) noexcept {
  constexpr double kMean = 6.0 - 12 * 0x1.0p-17;
  std::uint64_t sum = 0;
  for (std::uint64_t draw = 3 * number; draw < 3 * number + 3; ++draw) {
    const std::uint64_t bits = random(draw);
    for (int lane = 0; lane < 64; lane += 16) sum += bits >> lane & 0xffffU;
  }
  return static_cast<double>(sum) * 0x1.0p-16 - kMean;
}

// Poisson numbers of one mean, exact to double precision, by inversion of the cumulative
// distribution (Devroye, Non-Uniform Random Variate Generation, III.2). One thread; a new mean
// costs O(mean + sqrt(mean)) and a draw its logarithm; memory is fixed.
class PoissonTable {
 public:
  static constexpr double kMaxMean = 256.0;  // sum up draws for more

  // 0 <= mean <= kMaxMean.
  void set_mean(double mean) noexcept;

  // The number that belongs to a uniform in [0, 1).
  [[nodiscard]] std::size_t draw(double uniform) const noexcept;

 private:
  std::array<double, 512> cumulative_{1.0};  // up to 0, 1, 2 ...
  std::size_t size_ = 1;
};

inline void PoissonTable::set_mean(double mean) noexcept {
  constexpr double kUnseen = 0x1.0p-60;  // below the step of a uniform
  double probability = portable_exp(-mean);
  double sum = probability;
  cumulative_[0] = sum;
  size_ = 1;
  while (size_ < cumulative_.size()) {
    const auto number = static_cast<double>(size_);
    probability *= mean / number;
    if (number > mean && probability < kUnseen) break;
    sum += probability;
    cumulative_[size_++] = sum;
  }
}

inline std::size_t PoissonTable::draw(double uniform) const noexcept {
  // The last entry takes what rounding has left above it.
  const auto last = cumulative_.begin() + static_cast<std::ptrdiff_t>(size_ - 1);
  return static_cast<std::size_t>(std::upper_bound(cumulative_.begin(), last, uniform) -
                                  cumulative_.begin());
}

}  // namespace asap::inline v0_1::synthetic
