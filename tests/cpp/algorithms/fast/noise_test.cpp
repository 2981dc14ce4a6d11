#include "algorithms/fast/noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "asap/algorithms/noise_filters.hpp"
#include "asap/core/random.hpp"

namespace asap::fast::noise_test {
namespace {

// ---- support ----

TEST(SupportMap, CountsTheEightNeighboursAndNotTheOwnPixel) {
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      SupportMap map(20, 20);
      map.clear(1000);
      EXPECT_FALSE(map.touch(10, 10, 1000, 50));
      const bool neighbour = std::max(std::abs(dx), std::abs(dy)) == 1;
      const auto x = static_cast<std::size_t>(10 + dx);
      const auto y = static_cast<std::size_t>(10 + dy);
      EXPECT_EQ(map.touch(x, y, 1050, 50), neighbour) << dx << ' ' << dy;
    }
  }
}

TEST(SupportMap, TheWindowIsInclusive) {
  SupportMap map(20, 20);
  map.clear(1000);
  map.touch(10, 10, 1000, 50);
  EXPECT_FALSE(map.touch(11, 10, 1051, 50));
  EXPECT_TRUE(map.touch(12, 10, 1101, 50));
}

// Every frame, every start: the same as the filter, which has 64-bit time.
TEST(SupportMap, AgreesWithTheFilterAcrossTheWrapAndAtTheBorder) {
  const CounterRandom random(3);
  for (const std::int64_t start : {0LL, 0x7fff'ff00LL, 0xffff'ff00LL}) {
    SupportMap map(5, 4);
    BackgroundActivityFilter filter({.width = 5, .height = 4, .window_us = 30});
    map.clear(static_cast<Stamp>(start));
    std::int64_t t = start;
    for (std::uint64_t i = 0; i < 5000; ++i) {
      t += static_cast<std::int64_t>(random(3 * i) % 20);
      Event event{.x = static_cast<std::uint16_t>(random(3 * i + 1) % 5),
                  .y = static_cast<std::uint16_t>(random(3 * i + 2) % 4),
                  .p = 0,
                  .t = t};
      const bool expected = filter.process({&event, 1}, &event) == 1;
      ASSERT_EQ(map.touch(event.x, event.y, static_cast<Stamp>(t), 30), expected) << i;
    }
  }
}

TEST(SupportMap, ScrubbingMakesNoOldEventYoungAgain) {
  SupportMap map(4, 4);
  map.clear(0);
  map.touch(1, 1, 0, 5000);
  std::uint64_t now_us = 0;
  for (int step = 0; step < 50; ++step) {
    now_us += 100'000'000;
    map.scrub(static_cast<Stamp>(now_us), 100'000'000);
    SupportMap copy = map;
    EXPECT_FALSE(copy.touch(2, 1, static_cast<Stamp>(now_us), 5000)) << step;
  }
}

// ---- the rate ----

// `busy`: share of the columns in which objects fire a hundred times as much.
float measured(float rate_hz, double busy, int width = 346, int height = 260) {
  NoiseTiles tiles(width, height);
  const CounterRandom random(5);
  std::uint64_t drawn = 0;
  for (int step = 0; step < 100; ++step) {
    const auto events = static_cast<int>(rate_hz * 0.008F * static_cast<float>(width * height));
    for (int i = 0; i < events; ++i) {
      const double x = random.uniform(drawn++);
      const auto column = static_cast<std::size_t>(x * width);
      const auto row = static_cast<std::size_t>(random.uniform(drawn++) * height);
      for (int k = x < busy ? 100 : 1; k > 0; --k) tiles.count(column, row);
    }
    tiles.update(0.008F);
  }
  return tiles.rate_hz();
}

TEST(NoiseTiles, MeasureEvenNoise) {
  for (const float rate : {0.5F, 5.0F, 20.0F}) EXPECT_NEAR(measured(rate, 0), rate, 0.1F * rate);
}

TEST(NoiseTiles, ObjectsOnHalfOfTheFrameDoNotCount) { EXPECT_NEAR(measured(5, 0.5), 5, 1); }

TEST(NoiseTiles, AreAtMostFiveHundredTwelve) {
  for (const int side : {1, 17, 240, 1280, 16384}) {
    EXPECT_LE(NoiseTiles(side, side).size(), 512U) << side;
    EXPECT_GE(NoiseTiles(side, side).size(), 1U) << side;
  }
  EXPECT_EQ(NoiseTiles(346, 260).size(), 22U * 17U);
}

TEST(NoiseTiles, ClearForgets) {
  NoiseTiles tiles(32, 32);
  for (std::size_t i = 0; i < 4; ++i) tiles.count(16 * (i % 2), 16 * (i / 2));
  tiles.update(0.01F);
  EXPECT_GT(tiles.rate_hz(), 0);
  tiles.clear();
  tiles.update(0.01F);
  EXPECT_EQ(tiles.rate_hz(), 0);
}

TEST(NoiseSupport, CorrectsForSupportByChance) {
  for (const float all_hz : {0.5F, 2.0F, 10.0F}) {
    const float unsupported = all_hz * std::exp(-8 * all_hz * 0.005F);
    EXPECT_NEAR(total_noise(unsupported, 0.005F), all_hz, 0.02F * all_hz);
    EXPECT_NEAR(supported_noise(all_hz, 0.005F), all_hz - unsupported, 1e-3F * all_hz);
  }
  EXPECT_TRUE(std::isfinite(total_noise(1e6F, 0.05F)));
}

TEST(NoiseSupport, TheWindowIsLongerInLessNoise) {
  EXPECT_EQ(support_window_us(0, 5'000, 15'000), 15'000);
  EXPECT_EQ(support_window_us(1.25F, 5'000, 15'000), 10'000);  // 0.1 events of 8 pixels
  EXPECT_EQ(support_window_us(50, 5'000, 15'000), 5'000);
  EXPECT_EQ(support_window_us(0, 25'000, 15'000), 25'000);
}

}  // namespace
}  // namespace asap::fast::noise_test
