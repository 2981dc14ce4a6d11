// Counter-based random numbers: number i of a stream is a pure function of (seed, i), so a result
// depends on neither order, packages nor threads. Integer arithmetic only: the same bits on every
// platform. The mixing function is the finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
#pragma once

#include <cstdint>

namespace asap::inline v0_1 {

namespace detail {

constexpr std::uint64_t mix(std::uint64_t z) noexcept {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

}  // namespace detail

class CounterRandom {
 public:
  // Two seeds give two unrelated streams, neighbouring seeds included.
  explicit constexpr CounterRandom(std::uint64_t seed) noexcept
      : key_(detail::mix(seed + kGolden)) {}

  constexpr std::uint64_t operator()(std::uint64_t counter) const noexcept {
    return detail::mix(key_ + counter * kGolden);
  }

  // Uniform in [0, 1) with 53 bits.
  constexpr double uniform(std::uint64_t counter) const noexcept {
    return static_cast<double>((*this)(counter) >> 11) * 0x1.0p-53;
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15U;
  std::uint64_t key_;
};

}  // namespace asap::inline v0_1
