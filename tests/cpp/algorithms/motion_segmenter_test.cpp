#include "asap/algorithms/motion_segmenter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "asap/filter/gamma_filter.hpp"
#include "study/scenes/moving_shapes.hpp"

namespace motion_segmenter_test {
namespace {

using asap::Event;
using asap::EventSpan;
using asap::MotionSegmenter;
using asap::TrackedObject;
using Events = std::vector<Event>;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr std::int64_t kDuration_us = 300'000;

MotionSegmenter segmenter() { return MotionSegmenter({.width = kWidth, .height = kHeight}); }

// A disk that goes from the left to the right, before a ground that a camera moves past or at rest.
asap::MovingShapesConfig scene(bool has_ground, bool has_disk) {
  asap::MovingShapesConfig config{
      .width = kWidth, .height = kHeight, .duration_us = kDuration_us, .noise_hz = 1, .seed = 7};
  if (has_ground) {
    config.ground =
        asap::MovingGroundConfig{.shift_px_s = {-80, 50}, .turn_rad_s = 0.5, .zoom_per_s = 0.5};
  }
  if (has_disk) {
    const asap::Bounce path{.start = {30, 60},
                            .velocity = {250, 0},
                            .low = {20, 20},
                            .high = {kWidth - 20.0, kHeight - 20.0}};
    config.shapes.push_back({.radius_px = 12, .motion = {.path = path}});
  }
  return config;
}

Events events_of(const asap::MovingShapesConfig& config) {
  asap::MovingShapes shapes(config);
  return asap::read_events(shapes, std::numeric_limits<std::size_t>::max());
}

const Events& moving() {
  static const Events events = events_of(scene(true, true));
  return events;
}

// The events of the first `us`.
EventSpan until(const Events& events, std::int64_t us) {
  const auto end =
      std::find_if(events.begin(), events.end(), [&](const Event& event) { return event.t >= us; });
  return {events.begin(), end};
}

TEST(MotionSegmenter, FindsWhatMovesOnItsOwn) {
  auto found = segmenter();
  found.process(until(moving(), 250'000));
  const auto objects = found.objects();
  ASSERT_EQ(objects.size(), 1U);
  const TrackedObject& disk = objects.front();
  EXPECT_NEAR(disk.x, 30 + 250 * 0.25, 8);
  EXPECT_NEAR(disk.y, 60, 8);
  EXPECT_NEAR(disk.vx, 250, 100);
  EXPECT_NEAR(disk.vy, 0, 100);
  EXPECT_NEAR(disk.left + 0.5 * disk.width, disk.x, 1e-9);
  EXPECT_NEAR(disk.top + 0.5 * disk.height, disk.y, 1e-9);
  EXPECT_NEAR(disk.width, 24, 16);
  EXPECT_EQ(disk.independent, 1);
  EXPECT_GT(disk.size, 5);
  EXPECT_GE(disk.age_us, 30'000);
  EXPECT_LT(disk.t_last, 250'000);
  EXPECT_GT(disk.t_last, 230'000);
}

TEST(MotionSegmenter, KeepsTheIdAndPredicts) {
  auto found = segmenter();
  found.process(until(moving(), 200'000));
  const auto before = found.objects();
  const auto ahead = found.objects_at(210'000);
  found.process(until(moving(), 280'000).subspan(until(moving(), 200'000).size()));
  const auto after = found.objects();
  ASSERT_EQ(before.size(), 1U);
  ASSERT_EQ(ahead.size(), 1U);
  ASSERT_EQ(after.size(), 1U);
  EXPECT_EQ(before.front().id, after.front().id);
  EXPECT_NEAR(ahead.front().x - before.front().x, 0.01 * before.front().vx, 0.1);
  EXPECT_TRUE(found.objects_at(10'000'000).empty());
}

TEST(MotionSegmenter, FindsNothingWhereOnlyTheCameraMoves) {
  const Events events = events_of(scene(true, false));
  auto found = segmenter();
  std::size_t known = 0;
  for (const Event& event : events) {
    found.process({&event, 1});
    known += found.camera_motion().has_value();
    ASSERT_TRUE(found.objects().empty()) << event.t;
  }
  EXPECT_GT(known, events.size() / 2);
}

TEST(MotionSegmenter, TellsTheMotionOfTheBackground) {
  auto found = segmenter();
  found.process(moving());
  const auto motion = found.camera_motion();
  ASSERT_TRUE(motion);
  // The ground's shift turns and grows with the picture.
  const double scale = 1 + 0.5 * 0.29;
  const double turned = 0.5 * 0.29;
  EXPECT_NEAR(motion->vx, scale * (-80 * std::cos(turned) - 50 * std::sin(turned)), 40);
  EXPECT_NEAR(motion->vy, scale * (-80 * std::sin(turned) + 50 * std::cos(turned)), 40);
  EXPECT_NEAR(motion->turn, 0.5, 0.4);
  EXPECT_NEAR(motion->zoom, 0.5 / scale, 0.4);
  EXPECT_EQ(motion->t % 10'000, moving().front().t % 10'000);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_GT(motion->covariance[i][i], 0);
    for (std::size_t j = 0; j < 4; ++j) {
      EXPECT_NEAR(motion->covariance[i][j], motion->covariance[j][i],
                  1e-9 * std::sqrt(motion->covariance[i][i] * motion->covariance[j][j]));
    }
  }
  EXPECT_LT(std::sqrt(motion->covariance[0][0]), 20);
  EXPECT_LT(std::sqrt(motion->covariance[2][2]), 0.5);
}

TEST(MotionSegmenter, DoesNotKnowBeforeACameraAtRest) {
  const Events events = events_of(scene(false, true));
  auto found = segmenter();
  for (const Event& event : events) {
    found.process({&event, 1});
    ASSERT_FALSE(found.camera_motion());
  }
  EXPECT_TRUE(found.objects().empty());
}

TEST(MotionSegmenter, DoesNotKnowTheMotionAlongEdgesOfOneDirection) {
  // Upright edges 12 px apart that go to the right at 200 px/s, all over the frame.
  Events events;
  for (std::int64_t t = 0; t < 200'000; t += 5'000) {
    for (int line = 0; line < 14; ++line) {
      const auto x = static_cast<std::uint16_t>((12 * line + t / 5'000) % kWidth);
      for (std::uint16_t y = 0; y < kHeight; ++y) {
        events.push_back({.x = x, .y = y, .p = 1, .t = t + (7 * y) % 1'000});
      }
    }
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t < b.t; });
  auto found = segmenter();
  found.process(events);
  EXPECT_FALSE(found.camera_motion());
}

TEST(MotionSegmenter, UnknownTurnsIndependentToMinusOne) {
  auto found = segmenter();
  found.process(until(moving(), 250'000));
  ASSERT_EQ(found.objects().size(), 1U);
  ASSERT_EQ(found.objects().front().independent, 1);
  // Two steps without flow: the object goes on, and its independence is not known.
  found.process(Events{{.x = 3, .y = 3, .p = 1, .t = 271'000}});
  ASSERT_EQ(found.objects().size(), 1U);
  EXPECT_EQ(found.objects().front().independent, -1);
}

TEST(MotionSegmenter, ToldTheKeptFractionItKnowsMoreOften) {
  Events kept(moving().size());
  asap::GammaFilter thin(3);
  kept.resize(thin.apply(moving(), asap::KeepThreshold::clamped(0.2), kept));
  std::array<int, 2> known{};
  for (const bool is_told : {false, true}) {
    auto found = segmenter();
    if (is_told) found.set_gamma(0.2);
    for (const Event& event : kept) {
      found.process({&event, 1});
      known[is_told] += found.camera_motion().has_value();
    }
  }
  EXPECT_GT(known[1], known[0]);
}

}  // namespace
}  // namespace motion_segmenter_test
