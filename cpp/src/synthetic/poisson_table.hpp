// PoissonTable: Poisson numbers of one mean, exact to double precision, by inversion of the
// cumulative distribution (Devroye, Non-Uniform Random Variate Generation, III.2). One thread; a
// new mean costs O(mean + sqrt(mean)) and a draw its logarithm; memory is fixed. The same numbers
// on every platform: + - * / only.
#pragma once

#include <array>
#include <cstddef>

namespace asap {

class PoissonTable {
 public:
  static constexpr double kMaxMean = 256.0;  // sum up draws for more

  // 0 <= mean <= kMaxMean.
  void set_mean(double mean) noexcept;

  // The number that belongs to a uniform in [0, 1).
  [[nodiscard]] std::size_t draw(double uniform) const noexcept;

 private:
  std::array<double, 512> cumulative_{1.0};  // of 0, 1, 2 ...
  std::size_t size_ = 1;
};

}  // namespace asap
