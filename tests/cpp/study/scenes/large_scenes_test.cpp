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
        labels = mix(labels + static_cast<std::uint64_t>(label + 1));
    }
    return test::fingerprint(events) + labels;
  };
  EXPECT_EQ(first(scenes::large_shapes(kAll, 0)), 15655210246570286481U);
  EXPECT_EQ(first(scenes::large_disks(0)), 1649034215430005707U);
  EXPECT_EQ(first(scenes::hands(0)), 12567475284493778458U);
  EXPECT_EQ(first(scenes::moving_camera(0)), 5720696763383211887U);
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
