#include "asap/algorithms/noise_filters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "algorithms/recent_times.hpp"

namespace background_activity_filter_test {
namespace {

using std::chrono::microseconds;

using asap::BackgroundActivityFilter;
using asap::Event;
using asap::RecentTimes;
using Events = std::vector<Event>;

Event at(std::uint16_t x, std::uint16_t y, std::int64_t t, std::int16_t p = 0) {
  return {.x = x, .y = y, .p = p, .t = t};
}

Events passed(BackgroundActivityFilter& filter, const Events& events) {
  Events out(events.size());
  out.resize(filter.process(events, out));
  return out;
}

template <class Naive>
Events passed_by(Naive naive, const Events& events) {
  Events out;
  for (const Event& event : events) {
    if (naive.update(event)) out.push_back(event);
  }
  return out;
}

// One event at a time, to have a label for each.
std::vector<std::uint8_t> labels_of(BackgroundActivityFilter& filter, const Events& events) {
  std::vector<std::uint8_t> labels;
  for (const Event& event : events) {
    Event out;
    labels.push_back(static_cast<std::uint8_t>(filter.process({&event, 1}, {&out, 1})));
  }
  return labels;
}

TEST(BackgroundActivityFilter, GoldenVectors) {
  const auto events = asap::test::golden_corner_stream();
  BackgroundActivityFilter slow({.width = 346, .height = 260});
  const auto labels = labels_of(slow, events);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 98'269);
  EXPECT_EQ(asap::test::hash_of(labels), 0x98c65cd6U);

  BackgroundActivityFilter quick({.width = 346, .height = 260, .window = microseconds(1000)});
  const auto others = labels_of(quick, events);
  EXPECT_EQ(std::count(others.begin(), others.end(), 1), 38'473);
  EXPECT_EQ(asap::test::hash_of(others), 0x0b8f4236U);
}

TEST(BackgroundActivityFilter, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 20'000);
    for (const std::int64_t window :
         {std::int64_t{0}, std::int64_t{300}, RecentTimes::kMaxWindow_us}) {
      BackgroundActivityFilter filter(
          {.width = wild.width, .height = wild.height, .window = microseconds(window)});
      const asap::test::NaiveBackgroundActivityFilter naive(wild.width, wild.height, window);
      ASSERT_EQ(passed(filter, events), passed_by(naive, events)) << wild.seed << ' ' << window;
    }
  }
}

TEST(BackgroundActivityFilter, TheWindowGrowsAsNeighboursAreDiscarded) {
  const auto passes = [](double gamma, std::int64_t age) {
    BackgroundActivityFilter filter({.width = 9, .height = 9, .window = microseconds(1000)});
    filter.set_gamma(gamma);
    return passed(filter, {at(3, 4, 0), at(4, 4, age)}).size() == 1;
  };
  EXPECT_TRUE(passes(1, 1000));
  EXPECT_FALSE(passes(1, 1001));
  EXPECT_TRUE(passes(0.25, 4000));
  EXPECT_FALSE(passes(0.25, 4001));
  for (const double min : {0.0, 1e-300, 1e-6}) {
    EXPECT_TRUE(passes(min, RecentTimes::kMaxWindow_us)) << min;
    EXPECT_FALSE(passes(min, RecentTimes::kMaxWindow_us + 1)) << min;
  }
}

}  // namespace
}  // namespace background_activity_filter_test
