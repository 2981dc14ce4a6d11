#include "algorithms/motion/background_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/motion/motion_regions.hpp"

namespace asap::motion::background_motion_test {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr double kTurn_rad = 2.399;  // directions all over the circle

using Samples = std::vector<FlowSample>;

Motion motion() { return {120, -60, 20, 15}; }

// The flow of an edge of direction k at a pixel that moves by this velocity, with an error.
FlowSample sample(int x, int y, int k, const Eigen::Vector2d& velocity) {
  const double angle = kTurn_rad * k;
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  const double exact = velocity.dot(along);
  const double sign = exact < 0 ? -1 : 1;
  const double speed = exact + std::sqrt(2.0) * std::sin(5 * k) * (10 + 0.15 * sign * exact);
  return {.t = 0,
          .x = static_cast<std::uint16_t>(x),
          .y = static_cast<std::uint16_t>(y),
          .nx = static_cast<float>(sign * along.x()),
          .ny = static_cast<float>(sign * along.y()),
          .speed = static_cast<float>(sign * speed)};
}

// Flow of a ground that moves by motion(), every `step` px of columns up to `end`.
Samples ground(int step = 5, int end = kWidth) {
  const MotionFrame frame(kWidth, kHeight);
  Samples samples;
  for (int y = 2; y < kHeight; y += step) {
    for (int x = 2; x < end; x += step) {
      samples.push_back(
          sample(x, y, static_cast<int>(samples.size()), frame.velocity(motion(), {x, y})));
    }
  }
  return samples;
}

// A thing of 24 x 24 px with flow at every pixel.
void add_thing(Samples& samples, const Eigen::Vector2d& velocity) {
  for (int i = 0; i < 24 * 24; ++i) {
    samples.push_back(sample(60 + i % 24, 40 + i / 24, i, velocity));
  }
}

TEST(BackgroundMotion, IsThatOfTheGroundWhateverMovesBeforeIt) {
  for (const bool has_thing : {false, true}) {
    Samples samples = ground();
    if (has_thing) add_thing(samples, {-150, 100});
    BackgroundMotion background(kWidth, kHeight, samples.size());
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(background.fit(samples, 1));
    EXPECT_LT((background.motion() - motion()).norm(), 15) << has_thing;
  }
}

TEST(BackgroundMotion, IsUnknownWhereTheFlowSaysTooLittle) {
  const auto knows = [](const Samples& samples, double keep) {
    BackgroundMotion background(kWidth, kHeight, 10'000);
    return background.fit(samples, keep);
  };
  EXPECT_TRUE(knows(ground(), 1));
  EXPECT_FALSE(knows(ground(5, kWidth / 2), 1));  // half of the frame
  EXPECT_FALSE(knows(ground(15), 1));             // few in each block
  EXPECT_TRUE(knows(ground(15), 0.2));            // of a fifth of the events, enough
  Samples noise = ground();
  for (std::size_t i = 0; i < noise.size(); ++i) {
    noise[i].speed = static_cast<float>(100 + (i * 7919) % 900);
  }
  EXPECT_FALSE(knows(noise, 1));  // no motion fits
}

std::vector<Region> regions_of(const Samples& samples, double min_px_s, double min_share = 0) {
  BackgroundMotion background(kWidth, kHeight, samples.size());
  for (int i = 0; i < 5; ++i) background.fit(samples, 1);
  MotionRegions regions(kWidth, kHeight, min_px_s, min_share);
  const auto found = regions.find(samples, background);
  return {found.begin(), found.end()};
}

TEST(MotionRegions, AThingIsARegionIfItIsFastAndLarge) {
  Samples samples = ground();
  EXPECT_TRUE(regions_of(samples, 0).empty());  // errors alone
  for (int i = 0; i < 40; ++i) samples.push_back(sample(4, 4, i, {-150, 100}));
  EXPECT_TRUE(regions_of(samples, 40).empty());  // the four cells of a corner
  add_thing(samples, {-150, 100});
  const auto found = regions_of(samples, 40);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].centre.x(), 71.5, 4);
  EXPECT_NEAR(found[0].centre.y(), 51.5, 4);
  EXPECT_NEAR(found[0].velocity.x(), -150, 25);
  EXPECT_NEAR(found[0].velocity.y(), 100, 20);
  EXPECT_NEAR(found[0].half_size.x(), 12, 3);
  EXPECT_TRUE(regions_of(samples, 400).empty());  // 310 px/s beside the ground, which has 134
  EXPECT_EQ(regions_of(samples, 40, 1).size(), 1U);
  EXPECT_TRUE(regions_of(samples, 40, 2.5).empty());
}

}  // namespace
}  // namespace asap::motion::background_motion_test
