#include "synthetic/outline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace asap::outline_test {
namespace {

constexpr std::array<PlanePoint, 4> kSquare{{{0, 0}, {10, 0}, {10, 10}, {0, 10}}};

Outline square_at(double x, double y) {
  Outline outline{CounterRandom{3}};
  outline.add(kSquare, {x, y});
  return outline;
}

// Moves straight by (dx, dy) px in `steps` steps of step_us.
std::vector<Event> moved(Outline outline, double dx, double dy, int steps, std::int32_t step_us) {
  TimeSortedBlock block{100, 100, outline.size()};
  std::vector<Event> events;
  for (int i = 0; i < steps; ++i) {
    block.open(i * step_us, step_us);
    outline.sweep(Outline::place(dx * i / steps, dy * i / steps),
                  Outline::place(dx * (i + 1) / steps, dy * (i + 1) / steps), block);
    const EventSpan step = block.close();
    events.insert(events.end(), step.begin(), step.end());
  }
  return events;
}

TEST(Outline, ReleasesTwoEventsPerPixelSweptOffAheadAndOnBehind) {
  const auto events = moved(square_at(20, 30), 5.0, 0.0, 20, 100);
  const auto right = [](const Event& event) { return event.x >= 30 && event.x <= 35; };
  const auto left = [](const Event& event) { return event.x >= 20 && event.x <= 25; };
  EXPECT_EQ(std::ranges::count_if(events, right), 2 * 5 * 10);
  EXPECT_EQ(std::ranges::count_if(events, left), 2 * 5 * 10);
  EXPECT_EQ(events.size(), 200U);  // nothing from the edges along the motion
  for (const Event& event : events) {
    EXPECT_EQ(event.p, left(event) ? 1 : 0);
    EXPECT_TRUE(event.y >= 30 && event.y < 40) << event.y;
  }
}

TEST(Outline, DarkensWhereItGoes) {
  for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    const auto events = moved(square_at(20, 30), 4.0 * dx, 4.0 * dy, 16, 100);
    std::vector<int> darkened;  // px along the motion
    std::vector<int> brightened;
    for (const Event& event : events) {
      (event.p == 0 ? darkened : brightened).push_back(event.x * dx + event.y * dy);
    }
    ASSERT_EQ(darkened.size(), 80U);
    ASSERT_EQ(brightened.size(), 80U);
    EXPECT_NEAR(darkened.front() - brightened.front(), 10, 1);  // the size of the square
    EXPECT_NEAR(darkened.back() - darkened.front(), 4, 1);      // the way it went
    EXPECT_NEAR(brightened.back() - brightened.front(), 4, 1);
  }
}

TEST(Outline, CrossesWhenItReachesTheThresholdWhateverTheStep) {
  const auto coarse = moved(square_at(20.3, 30.3), 1.5, 0.75, 5, 800);
  const auto fine = moved(square_at(20.3, 30.3), 1.5, 0.75, 40, 100);
  ASSERT_FALSE(coarse.empty());
  ASSERT_EQ(coarse.size(), fine.size());
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(coarse[i].t), static_cast<double>(fine[i].t), 4.0);
  }
  // Spread over the whole step, ends included.
  std::array<int, 8> per_octant{};
  for (const Event& event : coarse) ++per_octant.at(static_cast<std::size_t>(event.t % 800 / 100));
  for (const int count : per_octant) EXPECT_GT(count, 0);
}

TEST(Outline, ForetellsItsRate) {
  const Outline square = square_at(20, 30);
  EXPECT_EQ(square.size(), 40U);
  EXPECT_DOUBLE_EQ(square.events_per_px({1.0, 0.0}), 2.0 * 20);
  EXPECT_NEAR(square.events_per_px({0.6, 0.8}), 2.0 * 20 * 1.4, 1e-2);
}

TEST(Outline, IsNotSeenOutsideTheSensor) {
  EXPECT_TRUE(moved(square_at(-30, 30), 5.0, 5.0, 20, 100).empty());
  EXPECT_TRUE(moved(square_at(30, 101), 5.0, 5.0, 20, 100).empty());
}

TEST(Outline, StepIsShortEnoughForItsSpeed) {
  for (const double speed : {0.0, 10.0, 1000.0, 1e5}) {
    const std::int32_t step_us = Outline::step_us(speed, 1'000'000);
    EXPECT_GE(step_us, 1);
    EXPECT_LE(step_us, TimeSortedBlock::kMaxStep_us);
    EXPECT_LE(speed * step_us * 1e-6, Outline::kLongestSweep_px);
  }
  EXPECT_EQ(Outline::step_us(1000.0, 1'000'000), 400);
  EXPECT_EQ(Outline::step_us(1000.0, 17), 17);
}

}  // namespace
}  // namespace asap::outline_test
