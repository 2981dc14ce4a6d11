#include "algorithms/fast/noise_tiles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "asap/core/random.hpp"

namespace noise_tiles_test {
namespace {

using asap::fast::noise_with_support;
using asap::fast::NoiseTiles;
using asap::fast::support_window_us;
using asap::fast::supported_noise;

// `busy`: share of the columns in which objects fire a hundred times as much.
float measured(float rate_hz, double busy, int width = 346, int height = 260) {
  NoiseTiles tiles(width, height);
  const asap::CounterRandom random(5);
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

TEST(NoiseSupport, InvertsTheShareThatHasNone) {
  for (const float all_hz : {0.5F, 2.0F, 10.0F}) {
    const float unsupported = all_hz * std::exp(-8 * all_hz * 0.005F);
    EXPECT_NEAR(noise_with_support(unsupported, 0.005F), all_hz, 0.02F * all_hz);
    EXPECT_NEAR(supported_noise(all_hz, 0.005F), all_hz - unsupported, 1e-3F * all_hz);
  }
  EXPECT_TRUE(std::isfinite(noise_with_support(1e6F, 0.05F)));
}

TEST(NoiseSupport, TheLessNoiseTheLongerItsWindow) {
  EXPECT_EQ(support_window_us(0, 5'000, 15'000), 15'000);
  EXPECT_EQ(support_window_us(1.25F, 5'000, 15'000), 10'000);  // 0.1 events of 8 pixels
  EXPECT_EQ(support_window_us(50, 5'000, 15'000), 5'000);
  EXPECT_EQ(support_window_us(0, 25'000, 15'000), 25'000);
}

}  // namespace
}  // namespace noise_tiles_test
