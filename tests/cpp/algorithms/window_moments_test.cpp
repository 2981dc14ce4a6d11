#include "algorithms/window_moments.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <random>
#include <vector>

#include "algorithms/brute_force_moments.hpp"

namespace asap::window_moments_test {
namespace {

// ---- WindowMoments --------------------------------------------------------------------------

using asap::Event;
using asap::WindowMoments;
using asap::test::BruteForce;
using asap::test::expect_moments;

Event random_event(std::mt19937_64& random, std::int64_t t, unsigned side = 346) {
  return {.x = static_cast<std::uint16_t>(random() % side),
          .y = static_cast<std::uint16_t>(random() % side),
          .p = 0,
          .t = t};
}

// A window of 50 events that slides for more than ten minutes, from each of these first stamps.
TEST(WindowMoments, EqualBruteForceAfterEveryEvent) {
  for (const std::int64_t start :
       {std::int64_t{0}, std::int64_t{-1'000'000}, std::int64_t{1'600'000'000'000'000}}) {
    std::mt19937_64 random(1);
    WindowMoments moments;
    std::deque<Event> events;
    std::int64_t t = start;
    for (int i = 0; i < 20'000; ++i) {
      t += static_cast<std::int64_t>(random() % 100'000);
      const Event event = random_event(random, t);
      moments.add(event.x, event.y, event.t);
      events.push_back(event);
      if (events.size() > 50) {
        moments.remove(events.front().x, events.front().y, events.front().t);
        events.pop_front();
      }
      ASSERT_EQ(moments.count(), events.size());
      expect_moments(moments.centroid(), moments.covariance(), moments.velocity(t),
                     BruteForce(events));
      ASSERT_FALSE(::testing::Test::HasFailure()) << "event " << i << " from " << start;
    }
    EXPECT_GT(t - start, 600'000'000);
  }
}

TEST(WindowMoments, LargestWindowAndFrameFit) {
  WindowMoments moments;
  std::vector<Event> events;
  for (int i = 0; i < 65'535; ++i) {
    const auto edge = static_cast<std::uint16_t>(i % 2 == 0 ? 0 : 65'535);
    events.push_back({.x = edge,
                      .y = static_cast<std::uint16_t>(65'535 - edge),
                      .p = 0,
                      .t = 1'600'000'000'000'000 + i});
    moments.add(events.back().x, events.back().y, events.back().t);
  }
  expect_moments(moments.centroid(), moments.covariance(), moments.velocity(events.back().t),
                 BruteForce(events));
}

TEST(WindowMoments, SumIsTheUnion) {
  std::mt19937_64 random(2);
  WindowMoments a;
  WindowMoments b;
  std::vector<Event> events;
  for (int i = 0; i < 100; ++i) {
    const Event event = random_event(random, 1'600'000'000'000'000 + 37 * i);
    (i % 3 == 0 ? a : b).add(event.x, event.y, event.t);
    events.push_back(event);
  }
  a += b;
  EXPECT_EQ(a.count(), 100U);
  expect_moments(a.centroid(), a.covariance(), a.velocity(events.back().t), BruteForce(events));
}

TEST(WindowMoments, StraightMotionHasItsVelocity) {
  WindowMoments moments;
  for (int i = 0; i < 100; ++i)
    moments.add(static_cast<std::uint64_t>(10 + i), static_cast<std::uint64_t>(300 - 2 * i),
                5000 * i);
  const asap::Vector2 velocity = moments.velocity(495'000);
  EXPECT_DOUBLE_EQ(velocity.x, 1 / 5000.0);
  EXPECT_DOUBLE_EQ(velocity.y, -2 / 5000.0);
}

TEST(WindowMoments, EqualStampsHaveNoVelocity) {
  for (const std::int64_t t :
       {std::int64_t{0}, std::int64_t{77}, std::int64_t{1'600'000'000'000'001}}) {
    WindowMoments moments;
    moments.add(1, 2, t);
    EXPECT_EQ(moments.velocity(t).x, 0);
    moments.add(300, 200, t);
    moments.add(7, 100, t);
    EXPECT_EQ(moments.velocity(t).x, 0);
    EXPECT_EQ(moments.velocity(t).y, 0);
  }
}

TEST(WindowMoments, OneMicrosecondIsASpan) {
  WindowMoments moments;
  moments.add(10, 20, 1'600'000'000'000'000);
  moments.add(11, 18, 1'600'000'000'000'001);
  EXPECT_DOUBLE_EQ(moments.velocity(1'600'000'000'000'001).x, 1);
  EXPECT_DOUBLE_EQ(moments.velocity(1'600'000'000'000'001).y, -2);
}

TEST(WindowMoments, SaysWhichSpansItResolves) {
  WindowMoments moments;
  for (int i = 0; i < 800; ++i) moments.add(0, 0, i);
  EXPECT_TRUE(moments.resolves(100'000'000));  // 100 s
  EXPECT_FALSE(moments.resolves(1'000'000'000));
  EXPECT_FALSE(moments.resolves(~std::uint64_t{0}));
}

// ---- chain_velocity -------------------------------------------------------------------------

using asap::EventWindow;

// One chain of `count` events, `step_us` apart, in a window that holds the events of another too.
void expect_regression(std::int64_t start, std::int64_t step_us, int count) {
  EventWindow window(static_cast<std::size_t>(2 * count));
  asap::WindowMoments moments;
  std::mt19937_64 random(1);
  std::vector<Event> events;
  EventWindow::Position newest = 0;
  for (int i = 0; i < count; ++i) {
    const Event event{.x = static_cast<std::uint16_t>(100 + i / 8 + static_cast<int>(random() % 9)),
                      .y = static_cast<std::uint16_t>(200 - i / 9 + static_cast<int>(random() % 9)),
                      .p = 0,
                      .t = start + step_us * i};
    window.append({.x = 9, .y = 9, .p = 0, .t = event.t}, 0, 1);
    const auto position = window.append(event, 0, 0);
    if (i > 0) window.join(position, newest);
    newest = position;
    moments.add(event.x, event.y, event.t);
    events.push_back(event);
  }
  asap::test::expect_moments(moments.centroid(), moments.covariance(),
                             asap::chain_velocity(window, newest, moments),
                             asap::test::BruteForce(events));
}

TEST(ChainVelocity, IsTheRegressionOverTheEventsOfTheChain) {
  for (const std::int64_t start : {std::int64_t{0}, std::int64_t{1'600'000'000'000'000}}) {
    expect_regression(start, 50, 300);
    expect_regression(start, 0, 300);  // equal stamps
    expect_regression(start, 1000, 1);
  }
}

// Ten minutes and a day: sums of squared microseconds do not fit 64 bits.
TEST(ChainVelocity, WalksWhereTheSumsOverflow) {
  for (const std::int64_t start : {std::int64_t{0}, std::int64_t{1'600'000'000'000'000}}) {
    expect_regression(start, 2'000'000, 300);
    expect_regression(start, 288'000'000, 300);
  }
}

}  // namespace
}  // namespace asap::window_moments_test
