#include "core/random.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace asap::random_test {
namespace {

constexpr std::uint64_t kLastSeed = std::numeric_limits<std::uint64_t>::max();

// Published numbers: SplitMix64 of seed 1234567, whose state starts one golden step further.
TEST(Mix, IsTheFinaliserOfSplitMix64) {
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15U;
  EXPECT_EQ(detail::mix(1234567 + golden), 6457827717110365317U);
  EXPECT_EQ(detail::mix(1234567 + 2 * golden), 3203168211198807973U);
}

// Fixed for ever: every kept set and every synthetic scene of a user hangs on them.
TEST(CounterRandom, GoldenValues) {
  EXPECT_EQ(CounterRandom(0)(0), 0x48218226ff3cd4bfU);
  EXPECT_EQ(CounterRandom(0)(1), 0xa706dd2f4d197e6fU);
  EXPECT_EQ(CounterRandom(0)(kLastSeed), 0xf85d28512d081c40U);
  EXPECT_EQ(CounterRandom(1)(0), 0xdce423fc82c0d5b8U);
  EXPECT_EQ(CounterRandom(kLastSeed)(0), 0x445018e305810b78U);
}

TEST(CounterRandom, IsAFunctionOfSeedAndCounter) {
  static_assert(CounterRandom(7)(3) == CounterRandom(7)(3));
  static_assert(CounterRandom(7)(3) != CounterRandom(7)(4));
  static_assert(CounterRandom(7)(3) != CounterRandom(8)(3));
}

TEST(CounterRandom, NeighbouringSeedsAreUnrelated) {
  for (std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{41}, kLastSeed}) {
    const CounterRandom a(seed);
    const CounterRandom b(seed + 1);
    int equal_bits = 0;
    for (std::uint64_t i = 0; i < 1000; ++i) {
      for (std::uint64_t shift = 0; shift < 4; ++shift) {
        ASSERT_NE(a(i), b(i + shift));
        ASSERT_NE(a(i + shift), b(i));
      }
      equal_bits += 64 - std::popcount(a(i) ^ b(i));
    }
    EXPECT_NEAR(equal_bits, 32000, 5 * std::sqrt(16000.0));
  }
}

TEST(CounterRandom, UniformLiesInTheHalfOpenUnitInterval) {
  const CounterRandom random(5);
  double sum = 0;
  double sum_of_squares = 0;
  constexpr int kCount = 100'000;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const double u = random.uniform(i);
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    sum_of_squares += u * u;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 5 * std::sqrt(1.0 / 12 / kCount));
  EXPECT_NEAR(sum_of_squares / kCount, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / kCount));
}

}  // namespace
}  // namespace asap::random_test
