#include "study/scenes/rigid_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace asap::rigid_motion_test {
namespace {

constexpr double kStep_s = 1e-6 * RigidMotion::kStep_us;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const Bounce kBounce{
    .start{50.0, 30.0}, .velocity{200.0, -120.0}, .low{10.0, 10.0}, .high{90.0, 60.0}};

void advance(RigidMotion& motion, int steps) {
  for (int step = 0; step < steps; ++step) motion.advance();
}

TEST(RigidMotion, GoesStraightAndBouncesByHand) {
  RigidMotion motion{{.path = kBounce}};
  advance(motion, 400);  // 0.1 s
  EXPECT_NEAR(motion.pose().position.x, 70.0, 1e-9);
  EXPECT_NEAR(motion.pose().position.y, 18.0, 1e-9);
  EXPECT_EQ(motion.pose().velocity.y, -120.0);
  advance(motion, 400);  // y: 6 is 4 beyond the box; x: at 90, about to turn
  EXPECT_NEAR(motion.pose().position.y, 14.0, 1e-9);
  EXPECT_EQ(motion.pose().velocity.y, 120.0);
  advance(motion, 400);
  EXPECT_NEAR(motion.pose().position.x, 70.0, 1e-9);
  EXPECT_EQ(motion.pose().velocity.x, -200.0);
}

TEST(RigidMotion, StaysInTheBox) {
  RigidMotion motion{{.path = kBounce}};
  for (int step = 0; step < 20'000; ++step) {
    motion.advance();
    const PlanePoint at = motion.pose().position;
    ASSERT_TRUE(at.x >= 10.0 && at.x <= 90.0 && at.y >= 10.0 && at.y <= 60.0) << step;
  }
}

TEST(RigidMotion, OrbitsAtItsSpeedEitherWay) {
  for (const double speed_px_s : {88.0, -88.0}) {
    RigidMotion motion{
        {.path = Orbit{.centre{100.0, 50.0}, .radius_px = 14.0, .speed_px_s = speed_px_s}}};
    EXPECT_DOUBLE_EQ(motion.pose().position.x, 114.0);
    EXPECT_DOUBLE_EQ(motion.pose().velocity.y, speed_px_s);
    advance(motion, 1000);
    const double angle = 0.25 * speed_px_s / 14.0;
    EXPECT_NEAR(motion.pose().position.x, 100.0 + 14.0 * std::cos(angle), 1e-4);
    EXPECT_NEAR(motion.pose().position.y, 50.0 + 14.0 * std::sin(angle), 1e-4);
  }
}

TEST(RigidMotion, VelocityIsTheDerivativeOfThePosition) {
  for (const RigidMotionConfig& config :
       {RigidMotionConfig{.path = kBounce},
        RigidMotionConfig{.path = Orbit{.speed_px_s = 100.0}, .pause{100'000, 200'000}}}) {
    RigidMotion motion{config};
    int jumps = 0;
    for (int step = 0; step < 1000; ++step) {
      const Pose before = motion.pose();
      motion.advance();
      const double x = (motion.pose().position.x - before.position.x) / kStep_s;
      const double y = (motion.pose().position.y - before.position.y) / kStep_s;
      if (std::abs(x - before.velocity.x) > 0.2 || std::abs(y - before.velocity.y) > 0.2) ++jumps;
    }
    EXPECT_EQ(jumps, std::holds_alternative<Bounce>(config.path) ? 2 : 0);
  }
}

TEST(RigidMotion, TurnsAtItsSpin) {
  RigidMotion motion{{.path = kBounce, .spin_rad_s = -2.0}};
  advance(motion, 2000);  // 0.5 s: -1 rad
  EXPECT_NEAR(motion.pose().axis.x, std::cos(1.0), 1e-6);
  EXPECT_NEAR(motion.pose().axis.y, -std::sin(1.0), 1e-6);
}

TEST(RigidMotion, StandsStillDuringThePauseAlone) {
  RigidMotion motion{{.path = kBounce, .spin_rad_s = 1.0, .pause{1000, 2000}}};
  advance(motion, 4);
  const Pose stopped = motion.pose();
  EXPECT_NEAR(stopped.position.x, 50.2, 1e-12);
  for (int step = 4; step < 8; ++step) {
    EXPECT_EQ(motion.pose().position.x, stopped.position.x);
    EXPECT_EQ(motion.pose().axis.y, stopped.axis.y);
    EXPECT_EQ(motion.pose().velocity.x, 0.0);
    motion.advance();
  }
  EXPECT_EQ(motion.pose().velocity.x, 200.0);
  motion.advance();
  EXPECT_NEAR(motion.pose().position.x, 50.25, 1e-12);
  EXPECT_GT(motion.pose().axis.y, stopped.axis.y);
}

TEST(RigidMotion, RefusesABadConfiguration) {
  const auto refused = [](const RigidMotionConfig& config, const std::string& field) {
    try {
      const RigidMotion motion{config};
      ADD_FAILURE() << "accepted a bad " << field;
    } catch (const std::invalid_argument& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(field + " = ")) << error.what();
    }
  };
  refused({.path = Bounce{.start{1.0, 0.0}}}, "start.x");
  refused({.path = Bounce{.start{0.0, kNan}}}, "start.y");
  refused({.path = Bounce{.velocity{0.0, 2001.0}}}, "speed_px_s");
  refused({.path = Bounce{.high{1e9, 0.0}}}, "box");
  refused({.path = Orbit{.centre{kNan, 0.0}}}, "centre");
  refused({.path = Orbit{.radius_px = 0.5}}, "radius_px");
  refused({.path = Orbit{.speed_px_s = -2001.0}}, "speed_px_s");
  refused({.spin_rad_s = kNan}, "spin_rad_s");
  refused({.pause{2, 1}}, "pause.to_us");
}

}  // namespace
}  // namespace asap::rigid_motion_test
