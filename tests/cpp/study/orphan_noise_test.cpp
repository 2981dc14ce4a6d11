#include "study/orphan_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace asap::orphan_noise_test {
namespace {

void update(OrphanNoise& noise, int orphans, bool warming) {
  for (int i = 0; i < orphans; ++i) noise.count();
  noise.update(0.001F, 10'000, warming, 144, 0.015F);
}

TEST(OrphanNoise, FollowsTheRateQuicklyAtFirst) {
  OrphanNoise noise;
  update(noise, 20, true);  // 2 Hz per pixel
  EXPECT_FLOAT_EQ(noise.rate_hz(), 0.4F);
  update(noise, 20, true);
  EXPECT_FLOAT_EQ(noise.rate_hz(), 0.72F);
  update(noise, 0, false);
  EXPECT_FLOAT_EQ(noise.rate_hz(), 0.72F * 0.97F);
}

TEST(OrphanNoise, TheThresholdIsFourDeviationsAboveTheNoise) {
  OrphanNoise noise;
  EXPECT_EQ(noise.threshold(), std::numeric_limits<float>::infinity());
  for (int i = 0; i < 100; ++i) update(noise, 20, true);
  EXPECT_EQ(noise.threshold(), std::numeric_limits<float>::infinity());
  update(noise, 20, false);
  const float expected = 2 * 144 * 0.015F;
  EXPECT_NEAR(noise.threshold(), expected + 4 * std::sqrt(expected) + 2, 1e-3);
}

TEST(OrphanNoise, TheThresholdIsSixEventsAtLeast) {
  OrphanNoise noise;
  update(noise, 0, false);
  EXPECT_EQ(noise.threshold(), 6);
}

}  // namespace
}  // namespace asap::orphan_noise_test
