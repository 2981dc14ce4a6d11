#include "algorithms/arc_filter.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "support/errors.hpp"

namespace arc_filter_test {
namespace {

using asap::ArcFilter;
using asap::Event;
using asap::SensorFrame;

Event at(std::int64_t t, std::int16_t p) { return {.x = 1, .y = 1, .p = p, .t = t}; }

TEST(ArcFilter, LetsTheFirstOfABurstThrough) {
  ArcFilter filter(SensorFrame(3, 3), 50);
  EXPECT_TRUE(filter.passes(at(51, 1)));
  EXPECT_FALSE(filter.passes(at(60, 1)));
  EXPECT_FALSE(filter.passes(at(110, 1)));  // 50 after the last: not older
  EXPECT_TRUE(filter.passes(at(161, 1)));
  EXPECT_TRUE(filter.passes({.x = 0, .y = 1, .p = 1, .t = 161}));
}

TEST(ArcFilter, LetsAChangeOfPolarityThrough) {
  ArcFilter filter(SensorFrame(3, 3), 50);
  EXPECT_TRUE(filter.passes(at(100, 1)));
  EXPECT_TRUE(filter.passes(at(110, 0)));
  EXPECT_TRUE(filter.passes(at(120, 1)));
  EXPECT_FALSE(filter.passes(at(121, 1)));
  EXPECT_TRUE(filter.passes(at(121, 0)));
  EXPECT_FALSE(filter.passes(at(121, 1)));  // the other polarity fired at the same time, not since
}

TEST(ArcFilter, APixelWithoutAnEventCountsAsFiredAtZero) {
  ArcFilter filter(SensorFrame(3, 3), 50);
  EXPECT_FALSE(filter.passes(at(50, 1)));
  filter.clear();
  EXPECT_TRUE(filter.passes(at(51, 1)));
  filter.clear();
  EXPECT_FALSE(filter.passes(at(-1000, 1)));  // or before the first stamp
  EXPECT_FALSE(filter.passes({.x = 2, .y = 2, .p = 1, .t = -951}));
  EXPECT_TRUE(filter.passes({.x = 2, .y = 1, .p = 1, .t = -950}));
}

TEST(ArcFilter, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    for (const std::int64_t window :
         {std::int64_t{0}, std::int64_t{50'000}, asap::RecentTimes::kMaxWindow_us}) {
      ArcFilter filter(SensorFrame(wild.width, wild.height), window);
      asap::test::NaiveArcFilter naive(wild.width, wild.height, window);
      for (const Event& event : asap::test::wild_stream(wild, 5000)) {
        ASSERT_EQ(filter.passes(event), naive.passes(event)) << wild.seed << ' ' << event.t;
      }
    }
  }
}

TEST(ArcFilter, NamesABadWindow) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { ArcFilter(SensorFrame(3, 3), -1); }),
            "filter_us = -1: must be 0 to 500000000 us");
  EXPECT_EQ(error_of([] { ArcFilter(SensorFrame(3, 3), 500'000'001); }),
            "filter_us = 500000001: must be 0 to 500000000 us");
}

}  // namespace
}  // namespace arc_filter_test
