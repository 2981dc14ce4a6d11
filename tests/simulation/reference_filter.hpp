// ReferenceFilter: which events a stratum keeps follows from the seed, their numbers and the
// threshold alone.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap::simulation {

// The number that decides an event: SplitMix64, 63 bits.
inline std::uint64_t event_number(std::uint64_t seed, std::uint64_t index) noexcept {
  constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15U;
  const auto shuffled = [](std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  };
  return shuffled(shuffled(seed + kStep) + index * kStep) >> 1;
}

// Appends the indices of [begin, end) that are kept.
class ReferenceFilter {
 public:
  explicit ReferenceFilter(std::uint64_t seed) noexcept : seed_(seed) {}

  void keep(std::uint64_t begin, std::uint64_t end, double gamma,
            std::vector<std::uint64_t>& kept) {
    const auto threshold = static_cast<std::uint64_t>(gamma * 0x1.0p63);
    for (std::uint64_t i = begin; i < end; ++i) {
      if (gamma >= 1 || event_number(seed_, i) < threshold) kept.push_back(i);
    }
  }

  // Those of the smallest numbers, so many of them as gamma says.
  void keep_exactly(std::uint64_t begin, std::uint64_t end, double gamma,
                    std::vector<std::uint64_t>& kept) {
    const auto size = static_cast<std::size_t>(gamma * static_cast<double>(end - begin) + 1e-6);
    if (size >= end - begin) return keep(begin, end, 1, kept);
    numbers_.clear();
    for (std::uint64_t i = begin; i < end; ++i) numbers_.push_back(event_number(seed_, i));
    sorted_ = numbers_;
    std::nth_element(sorted_.begin(), sorted_.begin() + static_cast<std::ptrdiff_t>(size),
                     sorted_.end());
    for (std::uint64_t i = begin; i < end; ++i) {
      if (numbers_[i - begin] < sorted_[size]) kept.push_back(i);
    }
  }

 private:
  const std::uint64_t seed_;
  std::vector<std::uint64_t> numbers_;
  std::vector<std::uint64_t> sorted_;
};

}  // namespace asap::simulation
