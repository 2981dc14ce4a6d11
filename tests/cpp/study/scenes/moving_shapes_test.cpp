#include "study/scenes/moving_shapes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "synthetic/scene_checks.hpp"

namespace asap::moving_shapes_test {
namespace {

using test::all_events;
using test::expect_well_formed;

MovingShape moving(ShapeKind kind, double radius_px, PlanePoint start, PlanePoint velocity) {
  return {
      .kind = kind,
      .radius_px = radius_px,
      .motion{.path = Bounce{.start = start, .velocity = velocity, .low{12, 12}, .high{107, 77}},
              .spin_rad_s = 2.0}};
}

// The five kinds, far from each other, on small orbits.
MovingShapesConfig apart(double noise_hz) {
  MovingShapesConfig config{.width = 160,
                            .height = 60,
                            .duration_us = 400'000,
                            .t0_us = 1'000,
                            .noise_hz = noise_hz,
                            .seed = 4};
  for (int i = 0; i < 5; ++i) {
    config.shapes.push_back(
        {.kind = static_cast<ShapeKind>(i),
         .radius_px = 8.0,
         .brightness = i % 2 == 0 ? 0.08 : 0.95,
         .motion{
             .path = Orbit{.centre{16.0 + 32.0 * i, 30.0}, .radius_px = 4.0, .speed_px_s = 60.0},
             .spin_rad_s = 3.0}});
  }
  return config;
}

struct Truth {
  std::vector<Event> events;
  std::vector<std::int32_t> labels;
};

Truth read_all(const MovingShapesConfig& config) {
  MovingShapes stream{config};
  Truth truth;
  for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
    EXPECT_EQ(stream.labels().size(), block.size());
    truth.events.insert(truth.events.end(), block.begin(), block.end());
    const auto labels = stream.labels();
    truth.labels.insert(truth.labels.end(), labels.begin(), labels.end());
  }
  return truth;
}

double distance_px(const Event& event, const Pose& pose, const RigidShape& shape) {
  const double dx = event.x - pose.position.x;
  const double dy = event.y - pose.position.y;
  return std::abs(shape.distance_px(
      {dx * pose.axis.x + dy * pose.axis.y, dy * pose.axis.x - dx * pose.axis.y}));
}

TEST(MovingShapes, IsWellFormed) {
  const auto config = apart(5.0);
  expect_well_formed(all_events<MovingShapes>(config), config);
  const MovingShapesConfig tiny{.width = 16,
                                .height = 16,
                                .duration_us = 10'000,
                                .t0_us = std::int64_t{1} << 62,
                                .noise_hz = 3900.0,
                                .shapes{moving(ShapeKind::kStar, 40.0, {12, 12}, {2000, 0})}};
  expect_well_formed(all_events<MovingShapes>(tiny), tiny);
}

TEST(MovingShapes, EveryEventLiesOnTheOutlineOfItsShape) {
  const auto config = apart(0.0);
  MovingShapes stream{config};
  std::array<std::size_t, 5> counts{};
  for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
    for (std::size_t i = 0; i < block.size(); ++i) {
      const auto label = static_cast<std::size_t>(stream.labels()[i]);
      ++counts.at(label);
      ASSERT_LE(distance_px(block[i], stream.poses()[label], stream.shapes()[label]), 0.55);
    }
  }
  for (const std::size_t count : counts) EXPECT_GT(count, 1000U);
}

// A shape darker than the ground turns pixels off in front and on behind; a bright one otherwise.
TEST(MovingShapes, PolarityIsThatOfTheEdge) {
  for (const double brightness : {0.08, 0.95}) {
    MovingShapesConfig config{.width = 120, .height = 90, .duration_us = 300'000, .noise_hz = 0.0};
    config.shapes = {moving(ShapeKind::kDisk, 10.0, {20.0, 45.0}, {200.0, 0.0})};
    config.shapes[0].brightness = brightness;
    MovingShapes stream{config};
    std::size_t events = 0;
    for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
      for (const Event& event : block) {
        const bool ahead = event.x > stream.poses()[0].position.x;
        if (std::abs(event.x - stream.poses()[0].position.x) < 1.0) continue;
        ASSERT_EQ(event.p == 1, ahead == (brightness > 0.5));
        ++events;
      }
    }
    EXPECT_GT(events, 1000U);
  }
}

// ln(0.5 / 0.08) / 0.25 = 7.3 thresholds at each of the two edges of a row, less about half a one
// where the way turns.
TEST(MovingShapes, NumberOfEventsIsThatOfTheThresholdsThatTheEdgesCross) {
  MovingShapesConfig config{.width = 120, .height = 90, .duration_us = 600'000, .noise_hz = 0.0};
  config.shapes = {moving(ShapeKind::kSquare, 10.0, {20.0, 45.0}, {100.0, 0.0})};
  config.shapes[0].motion.spin_rad_s = 0.0;
  const double edges = 2 * 20 * 60.0;
  const double thresholds = std::log(0.5 / 0.08) / 0.25;
  const auto events = static_cast<double>(all_events<MovingShapes>(config).size());
  EXPECT_NEAR(events / (edges * (thresholds - 0.5)), 1.0, 0.06);
}

TEST(MovingShapes, NoiseIsLabelledAndChangesNothingElse) {
  const Truth clean = read_all(apart(0.0));
  const Truth noisy = read_all(apart(20.0));
  Truth cleaned;
  std::size_t noise = 0;
  for (std::size_t i = 0; i < noisy.events.size(); ++i) {
    if (noisy.labels[i] == MovingShapes::kNoise) {
      ++noise;
    } else {
      cleaned.events.push_back(noisy.events[i]);
      cleaned.labels.push_back(noisy.labels[i]);
    }
  }
  EXPECT_EQ(cleaned.events, clean.events);
  EXPECT_EQ(cleaned.labels, clean.labels);
  const double expected = 20.0 * 160 * 60 * 0.4;
  EXPECT_NEAR(static_cast<double>(noise), expected, 5.0 * std::sqrt(expected));
}

TEST(MovingShapes, PosesOfTheStreamAreThoseOfTheWholeScene) {
  const auto config = apart(5.0);
  const std::vector<Pose> whole = poses_of(config);
  const std::size_t shapes = config.shapes.size();
  ASSERT_EQ(whole.size(), shapes * (400'000 / 250 + 1));
  MovingShapes stream{config};
  for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
    const auto step = static_cast<std::size_t>((block.front().t - config.t0_us) / 250);
    ASSERT_EQ(static_cast<std::size_t>((block.back().t - config.t0_us) / 250), step);
    for (std::size_t i = 0; i < shapes; ++i) {
      ASSERT_EQ(stream.poses()[i].position.x, whole[step * shapes + i].position.x);
      ASSERT_EQ(stream.poses()[i].velocity.y, whole[step * shapes + i].velocity.y);
      ASSERT_EQ(stream.poses()[i].axis.x, whole[step * shapes + i].axis.x);
    }
  }
}

}  // namespace
}  // namespace asap::moving_shapes_test
