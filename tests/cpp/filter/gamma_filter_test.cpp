#include "asap/filter/gamma_filter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap::gamma_filter_test {
namespace {

using test::error_of;
using test::evenly_spaced;
using test::Events;
using test::numbers_of;

using Numbers = std::vector<std::uint64_t>;

constexpr std::uint64_t kLastSeed = std::numeric_limits<std::uint64_t>::max();
constexpr std::array<std::uint64_t, 4> kSeeds{0, 1, 42, kLastSeed};
constexpr std::array<double, 5> kGammas{0.02, 0.1, 0.5, 0.75, 0.98};

Events apply(GammaFilter& filter, EventSpan events, double gamma) {
  Events kept(events.size());
  kept.resize(filter.apply(events, KeepThreshold::checked(gamma), kept));
  return kept;
}

std::vector<std::uint8_t> mask_of(std::uint64_t seed, double gamma, std::size_t count) {
  GammaFilter filter(seed);
  const Events events(count);
  std::vector<std::uint8_t> mask(count);
  filter.mask(events, KeepThreshold::checked(gamma), mask);
  return mask;
}

TEST(GammaFilter, DoesNotDependOnTheCuts) {
  const Events events = evenly_spaced(20'000, 1);
  for (const std::uint64_t seed : kSeeds) {
    GammaFilter whole(seed);
    const Events expected = apply(whole, events, 0.3);
    for (const std::size_t largest : {1u, 2u, 7u, 1000u, 4096u}) {
      GammaFilter cut(seed);
      const CounterRandom random(largest);
      Events kept;
      for (std::size_t at = 0; at < events.size();) {
        apply(cut, {}, 0.3);  // an empty part changes nothing
        const std::size_t size = std::min(1 + random(at) % largest, events.size() - at);
        const Events part = apply(cut, EventSpan(events).subspan(at, size), 0.3);
        kept.insert(kept.end(), part.begin(), part.end());
        at += size;
      }
      ASSERT_EQ(kept, expected) << "seed " << seed << ", parts up to " << largest;
      ASSERT_EQ(cut.position(), events.size());
    }
  }
}

TEST(GammaFilter, RefusesAGammaThatIsNone) {
  const auto error = [](double gamma) {
    return error_of([gamma] { (void)KeepThreshold::checked(gamma); });
  };
  EXPECT_EQ(error(std::numeric_limits<double>::quiet_NaN()),
            "gamma = nan: must be a number between 0 and 1");
  EXPECT_EQ(error(-0.1), "gamma = -0.1: must be a number between 0 and 1");
  EXPECT_EQ(error(1.1), "gamma = 1.1: must be a number between 0 and 1");
}

TEST(GammaFilter, ClampsOnTheHotPath) {
  EXPECT_TRUE(KeepThreshold::clamped(std::numeric_limits<double>::quiet_NaN()).keeps_all());
  EXPECT_TRUE(KeepThreshold::clamped(1.1).keeps_all());
  EXPECT_EQ(KeepThreshold::clamped(-0.1).value(), 0u);
  EXPECT_EQ(KeepThreshold::clamped(0.5).value(), std::uint64_t{1} << 62);
  EXPECT_FALSE(KeepThreshold::clamped(std::nextafter(1.0, 0.0)).keeps_all());
}

TEST(GammaFilter, SkipPassesOverNumbers) {
  const Events events = evenly_spaced(300, 1);
  GammaFilter whole(5);
  const Events all = apply(whole, events, 0.5);
  GammaFilter skipping(5);
  skipping.skip(100);
  const Events tail = apply(skipping, EventSpan(events).subspan(100), 0.5);
  EXPECT_TRUE(std::equal(tail.rbegin(), tail.rend(), all.rbegin()));
  EXPECT_EQ(skipping.position(), 300u);
}

// Fixed for ever: a user's published kept set must come out again.
TEST(GammaFilter, GoldenKeptSet) {
  const Events events = evenly_spaced(40, 1);
  GammaFilter zero(0);
  EXPECT_EQ(numbers_of(apply(zero, events, 0.25)), (Numbers{6, 12, 13, 20, 27, 33, 39}));
  GammaFilter last(kLastSeed);
  EXPECT_EQ(numbers_of(apply(last, events, 0.25)), (Numbers{6, 9, 12, 15, 16, 22, 26, 28, 36, 39}));
}

// Chi-square of observed against expected counts, as a number of standard deviations above its
// mean.
double chi_square_excess(const std::vector<double>& observed, const std::vector<double>& expected) {
  double chi = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    chi += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
  }
  const auto freedom = static_cast<double>(observed.size() - 1);
  return (chi - freedom) / std::sqrt(2 * freedom);
}

constexpr double kLimit = 4.5;  // seeds are fixed: passes always or never
constexpr std::size_t kDraws = 400'000;

TEST(GammaFilter, CountsAreBinomial) {
  constexpr std::size_t kBlock = 1000;
  for (const std::uint64_t seed : kSeeds) {
    for (const double gamma : kGammas) {
      const std::vector<std::uint8_t> mask = mask_of(seed, gamma, kDraws);
      double total = 0;
      double squares = 0;
      for (std::size_t block = 0; block < kDraws / kBlock; ++block) {
        double kept = 0;
        for (std::size_t i = 0; i < kBlock; ++i) kept += mask[block * kBlock + i];
        const double deviation = kept - gamma * kBlock;
        total += deviation;
        squares += deviation * deviation / (gamma * (1 - gamma) * kBlock);
      }
      const auto blocks = static_cast<double>(kDraws / kBlock);
      EXPECT_LT(std::abs(total), kLimit * std::sqrt(gamma * (1 - gamma) * kDraws))
          << "seed " << seed << ", gamma " << gamma;
      EXPECT_LT(std::abs(squares - blocks), kLimit * std::sqrt(2 * blocks))
          << "seed " << seed << ", gamma " << gamma;
    }
  }
}

TEST(GammaFilter, NeighboursAreIndependent) {
  for (const std::uint64_t seed : kSeeds) {
    for (const double gamma : kGammas) {
      const std::vector<std::uint8_t> mask = mask_of(seed, gamma, kDraws);
      for (const std::size_t distance : {1u, 2u, 3u, 16u}) {
        std::vector<double> observed(4);
        double pairs = 0;
        for (std::size_t i = 0; i + distance < kDraws; i += distance + 1) {
          observed[2U * mask[i] + mask[i + distance]] += 1;
          ++pairs;
        }
        const double none = 1 - gamma;
        const std::vector<double> expected{pairs * none * none, pairs * none * gamma,
                                           pairs * gamma * none, pairs * gamma * gamma};
        EXPECT_LT(chi_square_excess(observed, expected), kLimit)
            << "seed " << seed << ", gamma " << gamma << ", distance " << distance;
      }
    }
  }
}

TEST(GammaFilter, AThresholdKeepsExactlyAsManyAsAsked) {
  const test::Events events = test::evenly_spaced(500, 1);
  std::vector<std::uint64_t> numbers(events.size());
  test::Events out(events.size());
  for (const std::size_t before : {0u, 77u}) {
    for (const std::size_t count : {0u, 1u, 250u, 499u, 500u, 900u}) {
      GammaFilter filter(3);
      filter.skip(before);
      const KeepThreshold threshold = filter.keeping(count, events.size(), numbers);
      EXPECT_EQ(filter.position(), before);
      EXPECT_EQ(filter.apply(events, threshold, out), std::min<std::size_t>(count, 500));
    }
  }
}

}  // namespace
}  // namespace asap::gamma_filter_test
