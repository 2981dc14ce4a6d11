#include "synthetic/poisson_table.hpp"

#include <algorithm>

#include "synthetic/portable_exp.hpp"

namespace asap {

void PoissonTable::set_mean(double mean) noexcept {
  constexpr double kUnseen = 0x1.0p-60;  // below the step of a uniform
  double probability = synthetic::portable_exp(-mean);
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

std::size_t PoissonTable::draw(double uniform) const noexcept {
  // The last entry takes what rounding has left above it.
  const auto last = cumulative_.begin() + static_cast<std::ptrdiff_t>(size_ - 1);
  return static_cast<std::size_t>(std::upper_bound(cumulative_.begin(), last, uniform) -
                                  cumulative_.begin());
}

}  // namespace asap
