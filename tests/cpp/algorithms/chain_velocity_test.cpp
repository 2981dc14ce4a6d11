#include "algorithms/chain_velocity.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "algorithms/brute_force_moments.hpp"

namespace chain_velocity_test {
namespace {

using asap::Event;
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
}  // namespace chain_velocity_test
