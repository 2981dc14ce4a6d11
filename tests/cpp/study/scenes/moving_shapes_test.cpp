#include "study/scenes/moving_shapes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "support/errors.hpp"
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

TEST(MovingShapes, EventsOfAShapeThatComesNearLieOnItsOutline) {
  constexpr std::int64_t kGrowth_us = 800'000;
  for (const ShapeKind kind : {ShapeKind::kDisk, ShapeKind::kTriangle}) {
    MovingShapesConfig config{
        .width = 120, .height = 90, .duration_us = 1'000'000, .noise_hz = 0.0};
    config.shapes = {moving(kind, 4.0, {60.0, 45.0}, {0.0, 0.0})};
    config.shapes[0].motion.spin_rad_s = 0.0;
    config.shapes[0].motion.growth = {10.0, kGrowth_us};
    const std::vector<Pose> poses = poses_of(config);
    EXPECT_EQ(poses.front().scale, 1.0);
    EXPECT_NEAR(poses[kGrowth_us / 250 / 2].scale, 1.0 / 0.55, 1e-12);  // half the way of .9
    EXPECT_NEAR(poses.back().scale, 10.0, 1e-12);

    MovingShapes stream{config};
    std::size_t late = 0;
    std::int64_t last_us = 0;
    for (EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
      const double scale = stream.poses()[0].scale;
      for (const Event& event : block) {
        const PlanePoint own{(event.x - 60.0) / scale, (event.y - 45.0) / scale};
        const double away_px = scale * std::abs(stream.shapes()[0].distance_px(own));
        ASSERT_LE(away_px, 0.7);  // 0.11 px per step at the end
        late += scale > 8.0;
        last_us = event.t;
      }
    }
    EXPECT_GT(late, 500U);
    EXPECT_LT(last_us, kGrowth_us);
  }
}

// In each period a pixel that a lamp covers fires once when it is lit and once when it is not.
TEST(MovingShapes, ALampFlickersWithItsPeriod) {
  for (const std::int64_t period_us : {1'000, 10'000, 20'000}) {
    MovingShapesConfig config{
        .width = 40, .height = 40, .duration_us = 100'000, .noise_hz = 0.0, .shapes{MovingShape{}}};
    config.shapes[0] = moving(ShapeKind::kSquare, 4.5, {20.0, 20.0}, {0.0, 0.0});
    config.shapes[0].motion.spin_rad_s = 0.0;
    config.shapes[0].brightness = 0.95;
    config.shapes[0].flicker = {period_us, period_us / 4};
    const auto [events, labels] = read_all(config);
    EXPECT_EQ(labels, std::vector<std::int32_t>(events.size(), 0));
    EXPECT_EQ(events.size(), 81U * 200'000U / static_cast<std::size_t>(period_us));
    std::map<std::pair<std::uint16_t, std::uint16_t>, Event> last;
    for (const Event& event : events) {
      const auto [before, is_first] = last.try_emplace({event.x, event.y}, event);
      if (!is_first) {
        ASSERT_NE(event.p, before->second.p);
        ASSERT_NEAR(static_cast<double>(event.t - before->second.t),
                    static_cast<double>(period_us) / 2, 250.0);
        before->second = event;
      }
    }
  }
}

TEST(MovingShapes, DecoysHaveNoTruthAndNoiseAsLabel) {
  auto config = apart(0.0);
  const Truth all = read_all(config);
  config.decoys = 2;
  const Truth some = read_all(config);
  EXPECT_EQ(some.events, all.events);
  std::vector<std::int32_t> expected = all.labels;
  for (std::int32_t& label : expected) label = label < 3 ? label : MovingShapes::kNoise;
  EXPECT_EQ(some.labels, expected);
  EXPECT_EQ(objects_of(config).size(), 3U);
  EXPECT_EQ(poses_of(config).size(), 3U * (400'000 / 250 + 1));
}

TEST(MovingShapes, WiresHideWhatMovesBehindThemAndCauseNoEvent) {
  for (const UnitVector across : {UnitVector{1.0, 0.0}, UnitVector{0.8, 0.6}}) {
    MovingShapesConfig config{.width = 120, .height = 90, .duration_us = 300'000, .noise_hz = 0.0};
    config.shapes = {moving(ShapeKind::kDisk, 10.0, {20.0, 45.0}, {200.0, 30.0})};
    const auto hidden = [&](const Truth& truth) {
      return std::ranges::count_if(truth.events, [&](const Event& event) {
        const double wires = (event.x * across.x + event.y * across.y) / 10.0;
        return std::abs(wires - std::round(wires)) * 10.0 < 1.499;  // 4 px wide, but for mixed ones
      });
    };
    const Truth open = read_all(config);
    config.fence = FenceConfig{.across{across}, .pitch_px = 10.0, .wire_px = 4.0};
    const Truth fenced = read_all(config);
    EXPECT_GT(hidden(open), 1000);
    EXPECT_EQ(hidden(fenced), 0);
    const double share =
        static_cast<double>(fenced.events.size()) / static_cast<double>(open.events.size());
    EXPECT_GT(share, 0.5);
    EXPECT_LT(share, 0.7);
    EXPECT_EQ(fenced.labels, std::vector<std::int32_t>(fenced.events.size(), 0));
  }
}

TEST(MovingShapes, RefusesByName) {
  const auto refused = [](auto&& spoil) {
    auto config = apart(0.0);
    spoil(config);
    const std::string error = test::error_of([&] { MovingShapes{config}; });
    return error.substr(0, error.find(' '));
  };
  EXPECT_EQ(refused([](auto& config) { config.decoys = 6; }), "decoys");
  EXPECT_EQ(refused([](auto& config) { config.shapes[1].flicker.period_us = 750; }),
            "flicker.period_us");
  EXPECT_EQ(refused([](auto& config) { config.shapes[1].flicker.begun_us = 1; }),
            "flicker.begun_us");
  EXPECT_EQ(refused([](auto& config) { config.shapes[1].motion.growth.factor = 0.5; }),
            "growth.factor");
  EXPECT_EQ(refused([](auto& config) { config.shapes[1].motion.growth.duration_us = 0; }),
            "growth.duration_us");
  EXPECT_EQ(refused([](auto& config) { config.fence = FenceConfig{.wire_px = 16.0}; }), "wire_px");
  EXPECT_EQ(refused([](auto& config) { config.fence = FenceConfig{.brightness = 0.0}; }),
            "brightness");
}

}  // namespace
}  // namespace asap::moving_shapes_test
