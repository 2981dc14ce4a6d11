#include "study/scenes/large_scenes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "synthetic/scene_checks.hpp"

namespace asap::large_scenes_test {
namespace {

constexpr std::array kAll{ShapeKind::kBar, ShapeKind::kAngle, ShapeKind::kRing};

double speed_px_s(const MovingShape& shape) {
  const PlanePoint velocity = std::get<Bounce>(shape.motion.path).velocity;
  return std::sqrt(velocity.x * velocity.x + velocity.y * velocity.y);
}

void expect_between(double value, double low, double high) {
  EXPECT_GE(value, low - 1e-9);
  EXPECT_LE(value, high + 1e-9);
}

TEST(LargeScenes, LargeShapesAreTheKindsInTurn) {
  for (const std::uint64_t seed : {0U, 7U}) {
    const auto config = scenes::large_shapes(kAll, seed);
    EXPECT_EQ(config.width, 240);
    EXPECT_EQ(config.height, 180);
    EXPECT_EQ(config.noise_hz, 1.0);
    ASSERT_EQ(config.shapes.size(), 6U);
    for (std::size_t i = 0; i < 6; ++i) {
      const MovingShape& shape = config.shapes[i];
      EXPECT_EQ(shape.kind, kAll[i % 3]);
      expect_between(speed_px_s(shape), 60.0, 400.0);
      EXPECT_EQ(shape.motion.spin_rad_s > 0.0, i % 2 == 0);
    }
    for (const std::size_t bar : {0U, 3U}) {
      expect_between(2.0 * config.shapes[bar].radius_px, 60.0, 90.0);
      expect_between(config.shapes[bar].thickness_px, 8.0, 14.0);
    }
    EXPECT_EQ(config.shapes[1].radius_px, 40.0);
    expect_between(config.shapes[2].radius_px, 14.0, 30.0);
  }
}

TEST(LargeScenes, OneKindAlone) {
  constexpr std::array kRings{ShapeKind::kRing};
  for (const MovingShape& shape : scenes::large_shapes(kRings, 1).shapes) {
    EXPECT_EQ(shape.kind, ShapeKind::kRing);
  }
  EXPECT_THROW(scenes::large_shapes({}, 1), std::invalid_argument);
  constexpr std::array kDisks{ShapeKind::kDisk};
  EXPECT_THROW(scenes::large_shapes(kDisks, 1), std::invalid_argument);
}

TEST(LargeScenes, DisksArePlainAndTextured) {
  const auto config = scenes::large_disks(4);
  ASSERT_EQ(config.shapes.size(), 6U);
  std::size_t textured = 0;
  for (const MovingShape& shape : config.shapes) {
    EXPECT_EQ(shape.kind, ShapeKind::kDisk);
    expect_between(shape.radius_px, 14.0, 34.0);
    textured += shape.textured;
  }
  EXPECT_EQ(textured, 3U);
}

TEST(LargeScenes, HandsHaveFiveFingersThatReachOutOfThePalm) {
  const auto config = scenes::hands(2);
  ASSERT_EQ(config.shapes.size(), 2U);
  for (const MovingShape& hand : config.shapes) {
    EXPECT_EQ(2.0 * hand.radius_px, 55.0);
    ASSERT_EQ(hand.limbs.size(), 5U);
    expect_between(speed_px_s(hand), 50.0, 200.0);
    expect_between(reach_px(hand), 45.0, 65.0);
    for (const LimbConfig& finger : hand.limbs) expect_between(finger.rate_hz, 1.0, 3.0);
  }
}

TEST(LargeScenes, TheCameraMovesBehindTwoOrThreeMovers) {
  for (const std::uint64_t seed : {0U, 1U, 2U, 3U}) {
    const auto config = scenes::moving_camera(seed);
    EXPECT_EQ(config.shapes.size(), 2 + seed % 2);
    ASSERT_TRUE(config.ground.has_value());
    EXPECT_NE(config.ground->turn_rad_s, 0.0);
    for (const MovingShape& shape : config.shapes) expect_between(shape.radius_px, 5.0, 20.0);
  }
}

// The same events on every compiler and machine: a change of them changes published figures.
TEST(LargeScenes, AreGolden) {
  const auto first = [](const MovingShapesConfig& config) {
    MovingShapes stream{config};
    std::vector<Event> events;
    std::uint64_t labels = 0;
    while (events.size() < 20'000) {
      const EventSpan block = stream.next();
      events.insert(events.end(), block.begin(), block.end());
      for (const std::int32_t label : stream.labels())
        labels = detail::mix(labels + static_cast<std::uint64_t>(label + 1));
    }
    return test::fingerprint(events) + labels;
  };
  EXPECT_EQ(first(scenes::large_shapes(kAll, 0)), 15655210246570286481U);
  EXPECT_EQ(first(scenes::large_disks(0)), 1649034215430005707U);
  EXPECT_EQ(first(scenes::hands(0)), 12567475284493778458U);
  EXPECT_EQ(first(scenes::moving_camera(0)), 5720696763383211887U);
}

// What a texture or the ground shows moves; before a ground at rest there is noise alone.
TEST(LargeScenes, TheGroundIsLabelledAsNoise) {
  auto config = scenes::moving_camera(1);
  config.duration_us = 100'000;
  config.noise_hz = 0.0;
  const auto without_label = [](const MovingShapesConfig& scene) {
    MovingShapes stream{scene};
    std::size_t count = 0;
    for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
      for (const std::int32_t label : stream.labels()) count += label == MovingShapes::kNoise;
    }
    return count;
  };
  EXPECT_GT(without_label(config), 1000U);
  config.ground = MovingGroundConfig{};
  EXPECT_LT(without_label(config), 1000U);  // uncovered by the movers
}

TEST(LargeScenes, AWavingFingerIsTheHands) {
  auto config = scenes::hands(3);
  config.noise_hz = 0.0;
  config.duration_us = 100'000;
  for (MovingShape& hand : config.shapes) {
    hand.motion.spin_rad_s = 0.0;
    std::get<Bounce>(hand.motion.path).velocity = {0.0, 0.0};
  }
  MovingShapes stream{config};
  std::size_t beyond_palm = 0;
  for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
    for (std::size_t i = 0; i < block.size(); ++i) {
      const auto label = static_cast<std::size_t>(stream.labels()[i]);
      const Pose& pose = stream.poses()[label];
      const double x = block[i].x - pose.position.x;
      const double y = block[i].y - pose.position.y;
      ASSERT_LT(std::sqrt(x * x + y * y), reach_px(config.shapes[label]) + 1.0);
      beyond_palm += std::sqrt(x * x + y * y) > 30.0;
    }
  }
  EXPECT_GT(beyond_palm, 500U);
}

}  // namespace
}  // namespace asap::large_scenes_test
