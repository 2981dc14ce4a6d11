#include "asap/algorithms/noise_filters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "algorithms/recent_times.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

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

TEST(BackgroundActivityFilter, AnyNeighbourIsCompanyForTheWholeWindow) {
  for (const int dy : {-1, 0, 1}) {
    for (const int dx : {-1, 0, 1}) {
      for (const std::int64_t age : {0, 100, 101}) {
        BackgroundActivityFilter filter({.width = 9, .height = 9, .window = microseconds(100)});
        const auto x = static_cast<std::uint16_t>(4 + dx);
        const auto y = static_cast<std::uint16_t>(4 + dy);
        const bool expected = age <= 100 && (dx != 0 || dy != 0);
        EXPECT_EQ(passed(filter, {at(x, y, 0, 1), at(4, 4, age)}).size(), expected ? 1U : 0U);
      }
    }
  }
}

TEST(BackgroundActivityFilter, NobodyKeepsCompanyAcrossBordersOrFromTwoPixelsAway) {
  for (const Event& far : {at(6, 4, 0), at(2, 4, 0), at(4, 2, 0), at(4, 6, 0)}) {
    BackgroundActivityFilter filter({.width = 9, .height = 9});
    EXPECT_TRUE(passed(filter, {far, at(4, 4, 0)}).empty());
  }
  BackgroundActivityFilter filter({.width = 9, .height = 9});
  EXPECT_TRUE(passed(filter, {at(8, 3, 0), at(0, 4, 0), at(8, 8, 0), at(0, 0, 0)}).empty());
}

TEST(BackgroundActivityFilter, TheFirstEventsOfAStreamAreAlone) {
  for (const std::int64_t start : {std::int64_t{-3}, std::int64_t{0}, std::int64_t{5}}) {
    BackgroundActivityFilter filter({.width = 9, .height = 9});
    EXPECT_TRUE(passed(filter, {at(4, 4, start), at(7, 7, start)}).empty());
  }
}

TEST(BackgroundActivityFilter, MayWriteOverItsInput) {
  auto events = asap::test::golden_corner_stream(20'000);
  BackgroundActivityFilter filter({.width = 346, .height = 260});
  const auto expected = passed(filter, events);
  filter.reset();
  events.resize(filter.process(events, events));
  EXPECT_EQ(events, expected);
}

TEST(BackgroundActivityFilter, DropsAndCountsEventsOutsideTheFrame) {
  BackgroundActivityFilter filter({.width = 9, .height = 5});
  const Events events{at(8, 4, 0), at(9, 4, 1LL << 60), at(8, 5, 1LL << 60), at(65535, 65535, 0),
                      at(8, 3, 5)};
  EXPECT_EQ(passed(filter, events), (Events{at(8, 3, 5)}));
  EXPECT_EQ(filter.rejected(), 3U);
}

TEST(BackgroundActivityFilter, TheWindowGrowsAsNeighboursAreDiscarded) {
  const auto passes = [](double gamma, std::int64_t age) {
    BackgroundActivityFilter filter({.width = 9, .height = 9, .window = microseconds(1000)});
    filter.set_keep(gamma);
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

TEST(BackgroundActivityFilter, KeepIsChecked) {
  BackgroundActivityFilter filter({.width = 9, .height = 9});
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(filter.set_keep(bad), std::invalid_argument);
  }
}

TEST(BackgroundActivityFilter, ResetIsANewFilter) {
  const auto events = asap::test::golden_corner_stream(20'000);
  BackgroundActivityFilter filter({.width = 346, .height = 260});
  const auto expected = passed(filter, events);
  filter.set_keep(0.1);
  passed(filter, {at(346, 0, 0)});
  filter.reset();
  EXPECT_EQ(filter.rejected(), 0U);
  EXPECT_EQ(passed(filter, events), expected);
}

TEST(BackgroundActivityFilter, NamesBadParameters) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { BackgroundActivityFilter({.width = 0, .height = 9}); }),
            "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of([] {
              BackgroundActivityFilter({.width = 9, .height = 9, .window = microseconds(-1)});
            }),
            "window_us = -1: must be 0 to 500000000 us");
  EXPECT_EQ(
      error_of([] {
        BackgroundActivityFilter({.width = 9, .height = 9, .window = microseconds(500000001)});
      }),
      "window_us = 500000001: must be 0 to 500000000 us");
}

TEST(BackgroundActivityFilter, ACopyGoesItsOwnWay) {
  const auto events = asap::test::golden_corner_stream(20'000);
  const Events first(events.begin(), events.begin() + 10'000);
  const Events second(events.begin() + 10'000, events.end());
  BackgroundActivityFilter filter({.width = 346, .height = 260});
  passed(filter, first);
  BackgroundActivityFilter copy = filter;
  BackgroundActivityFilter other({.width = 1, .height = 1});
  other = copy;
  BackgroundActivityFilter moved = std::move(copy);
  copy = other;  // what was moved from takes a new value
  const auto expected = passed(filter, second);
  for (BackgroundActivityFilter* each : {&moved, &other, &copy}) {
    EXPECT_EQ(passed(*each, second), expected);
    EXPECT_EQ(each->config().width, 346);
  }
}

TEST(BackgroundActivityFilter, AllocatesOnlyInTheConstructor) {
  const auto events = asap::test::golden_corner_stream(20'000);
  BackgroundActivityFilter filter({.width = 346, .height = 260});
  Events out(events.size());
  const std::size_t before = asap::test::allocations();
  filter.process(events, out);
  filter.set_keep(0.5);
  filter.reset();
  EXPECT_EQ(asap::test::allocations(), before);
}

}  // namespace
}  // namespace background_activity_filter_test
