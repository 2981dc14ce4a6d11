#include "algorithms/fast/position_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/fast/kalman_rule.hpp"

namespace position_error_test {
namespace {

using namespace asap::fast;

constexpr float kExtent_px = 5;

float doubt_after(float speed, float time_s, std::uint8_t partners = 0,
                  float first = Contour::kFirstDoubt) {
  Contour contour;
  contour.doubt = first;
  Track track;
  track.vy = -speed;
  track.partners = partners;
  for (float t = 0; t < time_s; t += 0.002F) doubt_outline(contour, track, kExtent_px, 0.002F);
  return contour.doubt;
}

TEST(PositionError, DoubtAboutTheOutlineFallsWithTheWay) {
  EXPECT_EQ(doubt_after(0, 1), Contour::kFirstDoubt);
  // 10 px are two extents.
  const float once = kLeastDoubt + (Contour::kFirstDoubt - kLeastDoubt) * std::exp(-1.0F);
  EXPECT_NEAR(doubt_after(100, 0.1F), once, 1e-3F);
  EXPECT_NEAR(doubt_after(50, 0.2F), once, 1e-3F);
  EXPECT_NEAR(doubt_after(400, 1), kLeastDoubt, 1e-6F);
}

TEST(PositionError, DoubtGrowsInContact) {
  const float soon = doubt_after(100, 0.05F, 1, kLeastDoubt);
  const float late = doubt_after(100, 1, 1, kLeastDoubt);
  EXPECT_GT(soon, 10 * kLeastDoubt);
  EXPECT_GT(late, 2 * soon);
  EXPECT_EQ(doubt_after(0, 0.05F, 2, kLeastDoubt), soon);
}

TEST(PositionError, APointHasADoubtToo) {
  Contour contour;
  Track track;
  track.vx = 100;
  doubt_outline(contour, track, 0, 0.002F);
  EXPECT_LT(contour.doubt, Contour::kFirstDoubt);
  EXPECT_GT(contour.doubt, 0.8F * Contour::kFirstDoubt);
}

TEST(PositionError, IsTheFiltersAndAShareOfTheEventsCovariance) {
  Track track;
  track.sxx = 40;
  track.sxy = -10;
  track.syy = 20;
  KalmanState state;
  state.pxx = 0.3F;
  state.stamp = 1000;
  Contour contour;
  contour.doubt = 0.01F;
  const PositionError error = position_error(track, state, contour, 1000, kRule);
  EXPECT_FLOAT_EQ(error.xx, 0.7F);
  EXPECT_FLOAT_EQ(error.xy, -0.1F);
  EXPECT_FLOAT_EQ(error.yy, 0.5F);
  EXPECT_GT(position_error(track, state, contour, 21'000, kRule).xx, error.xx);
}

}  // namespace
}  // namespace position_error_test
