#include "study/scenes/limb.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace asap::limb_test {
namespace {

constexpr Pose kUpright{.position{100.0, 50.0}, .velocity{7.0, 0.0}, .axis{}};
constexpr LimbConfig kStill{.length_px = 20.0, .width_px = 6.0, .joint{10.0, 0.0}};

TEST(Limb, BeginsAtItsJointAndPointsAlongItsDirection) {
  const Pose pose = Limb{kStill}.on(kUpright);
  EXPECT_DOUBLE_EQ(pose.position.x, 100.0 + 10.0 + 10.0);
  EXPECT_DOUBLE_EQ(pose.position.y, 50.0);
  EXPECT_DOUBLE_EQ(pose.axis.x, 1.0);
  EXPECT_EQ(pose.velocity.x, 7.0);
  EXPECT_DOUBLE_EQ((Limb{kStill}.shape().inner_px()), 3.0);
}

TEST(Limb, TurnsWithItsShape) {
  const Pose pose = Limb{kStill}.on({.position{100.0, 50.0}, .velocity{}, .axis{0.0, 1.0}});
  EXPECT_DOUBLE_EQ(pose.position.x, 100.0);
  EXPECT_DOUBLE_EQ(pose.position.y, 70.0);
  EXPECT_DOUBLE_EQ(pose.axis.y, 1.0);
}

TEST(Limb, WavesToBothSidesAtItsRate) {
  LimbConfig config = kStill;
  config.swing_rad = 0.4;
  config.rate_hz = 2.0;
  Limb limb{config};
  double most = 0.0;
  double least = 0.0;
  int crossings = 0;
  double before = 0.0;
  for (int step = 1; step <= 4200; ++step) {  // 1.05 s
    limb.advance();
    const double angle = std::asin(limb.on(kUpright).axis.y);
    most = std::max(most, angle);
    least = std::min(least, angle);
    crossings += before < 0.0 && angle >= 0.0;
    before = angle;
  }
  EXPECT_NEAR(most, 0.4, 0.01);
  EXPECT_NEAR(least, -0.4, 0.01);
  EXPECT_EQ(crossings, 2);  // at 0.5 and 1 s
}

TEST(Limb, RefusesABadWave) {
  EXPECT_THROW(Limb{{.swing_rad = 1.1}}, std::invalid_argument);
  EXPECT_THROW(Limb{{.rate_hz = std::nan("")}}, std::invalid_argument);
  EXPECT_THROW((Limb{{.length_px = 8.0, .width_px = 8.0}}), std::invalid_argument);
}

}  // namespace
}  // namespace asap::limb_test
