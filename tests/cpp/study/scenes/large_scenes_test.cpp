#include "study/scenes/large_scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "synthetic/scene_checks.hpp"

namespace asap::large_scenes_test {
namespace {

constexpr std::array kAll{ShapeKind::kBar, ShapeKind::kAngle, ShapeKind::kRing};

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
  EXPECT_EQ(first(scenes::sparse(0)), 3751869994132518339U);
  EXPECT_EQ(first(scenes::approaching(0)), 15379482432465957178U);
  EXPECT_EQ(first(scenes::lamps(0)), 14912853539546352557U);
  EXPECT_EQ(first(scenes::fence(0)), 1325065766560489428U);
}

class AHand : public ::testing::TestWithParam<double> {};

TEST_P(AHand, OwnsItsWavingFingersAtAnySize) {
  const double size = GetParam();
  auto config = scenes::hands(3);
  config.noise_hz = 0.0;
  config.duration_us = 100'000;
  for (MovingShape& hand : config.shapes) {
    hand.motion.spin_rad_s = 0.0;
    hand.motion.growth.factor = size;  // at once
    std::get<Bounce>(hand.motion.path).velocity = {0.0, 0.0};
  }
  MovingShapes stream{config};
  std::size_t beyond_palm = 0;
  double farthest = 0.0;  // of its reach
  for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
    for (std::size_t i = 0; i < block.size(); ++i) {
      const auto label = static_cast<std::size_t>(stream.labels()[i]);
      const Pose& pose = stream.poses()[label];
      const double x = block[i].x - pose.position.x;
      const double y = block[i].y - pose.position.y;
      const double away = std::sqrt(x * x + y * y);
      const double reach = size * reach_px(config.shapes[label]);
      ASSERT_LT(away, reach + 1.0);
      beyond_palm += away > size * 30.0;
      farthest = std::max(farthest, away / reach);
    }
  }
  EXPECT_GT(beyond_palm, 500U);
  EXPECT_GT(farthest, 0.92);
}

INSTANTIATE_TEST_SUITE_P(LargeScenes, AHand, ::testing::Values(1.0, 1.5));

}  // namespace
}  // namespace asap::large_scenes_test
