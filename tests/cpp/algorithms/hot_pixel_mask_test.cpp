#include "asap/algorithms/noise_filters.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

namespace hot_pixel_mask_test {
namespace {

using asap::Event;
using asap::HotPixelMask;
using asap::MaskedPixel;
using Events = std::vector<Event>;
using Pixels = std::vector<MaskedPixel>;

Event at(int x, int y, std::int64_t t = 0) {
  return {.x = static_cast<std::uint16_t>(x), .y = static_cast<std::uint16_t>(y), .p = 0, .t = t};
}

Events passed(HotPixelMask& mask, const Events& events) {
  Events out(events.size());
  out.resize(mask.process(events, out));
  return out;
}

// `count` events at each pixel, one after the other.
Events repeated(const Pixels& pixels, int count) {
  Events events;
  for (int i = 0; i < count; ++i) {
    for (const auto& [x, y] : pixels) events.push_back(at(x, y, i));
  }
  return events;
}

Pixels hot_pixels_of(const Events& events) {
  HotPixelMask mask({.width = 40, .height = 30});
  const std::size_t hot = mask.learn(events);
  EXPECT_EQ(mask.pixels().size(), hot);
  return mask.pixels();
}

TEST(HotPixelMask, PassesAllButTheGivenPixels) {
  HotPixelMask mask({.width = 9, .height = 5, .pixels = {{8, 4}, {0, 0}, {3, 2}, {3, 2}}});
  EXPECT_EQ(mask.pixels(), (Pixels{{0, 0}, {3, 2}, {8, 4}}));
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 9; ++x) {
      const bool masked = (x == 8 && y == 4) || (x == 0 && y == 0) || (x == 3 && y == 2);
      EXPECT_EQ(passed(mask, {at(x, y, 7)}), masked ? Events{} : Events{at(x, y, 7)});
      EXPECT_EQ(mask.is_masked(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)),
                masked);
    }
  }
}

TEST(HotPixelMask, AHotPixelHasAHundredEvents) {
  EXPECT_EQ(hot_pixels_of(repeated({{5, 6}}, 99)), (Pixels{}));
  EXPECT_EQ(hot_pixels_of(repeated({{5, 6}}, 100)), (Pixels{{5, 6}}));
}

TEST(HotPixelMask, AHotPixelHasAThousandthOfAll) {
  Events events = repeated({{5, 6}}, 120);
  for (int i = 0; i < 119'880; ++i) events.push_back(at(10 + i % 30, 10 + i / 30 % 20));
  EXPECT_EQ(hot_pixels_of(events), (Pixels{{5, 6}}));
  events.push_back(at(20, 20));
  EXPECT_EQ(hot_pixels_of(events), (Pixels{}));
}

TEST(HotPixelMask, HotPixelsComeInPairsTracksInThrees) {
  EXPECT_EQ(hot_pixels_of(repeated({{5, 6}, {6, 6}}, 500)), (Pixels{{5, 6}, {6, 6}}));
  EXPECT_EQ(hot_pixels_of(repeated({{5, 6}, {6, 6}, {7, 8}}, 500)), (Pixels{}));
  EXPECT_EQ(hot_pixels_of(repeated({{5, 6}, {6, 6}, {8, 6}}, 500)).size(), 2U);  // 8 is beyond 5
}

TEST(HotPixelMask, AHotPixelHasFiveTimesTheSecondBusiestAround) {
  for (const MaskedPixel& far : {MaskedPixel{3, 4}, MaskedPixel{7, 8}, MaskedPixel{3, 8}}) {
    Events events = repeated({{6, 6}, far}, 99);
    const Events hot = repeated({{5, 6}}, 494);
    events.insert(events.end(), hot.begin(), hot.end());
    EXPECT_EQ(hot_pixels_of(events), (Pixels{}));
    events.push_back(at(5, 6));
    EXPECT_EQ(hot_pixels_of(events), (Pixels{{5, 6}}));
  }
}

TEST(HotPixelMask, CornersOfTheFrameHaveNeighboursToo) {
  EXPECT_EQ(hot_pixels_of(repeated({{0, 0}, {39, 0}, {0, 29}, {39, 29}}, 100)),
            (Pixels{{0, 0}, {39, 0}, {0, 29}, {39, 29}}));
}

TEST(HotPixelMask, LearnsOnTheWay) {
  HotPixelMask mask({.width = 40, .height = 30, .learn_events = 1000});
  Events events = asap::test::wild_stream({}, 800);
  const Events hot = repeated({{5, 6}}, 200);
  events.insert(events.end(), hot.begin(), hot.end());
  EXPECT_EQ(passed(mask, events), events);
  EXPECT_EQ(mask.pixels(), (Pixels{{5, 6}}));
  EXPECT_TRUE(passed(mask, hot).empty());

  // Each time from nothing: 99 here and 99 there are not 198.
  Events fewer(901, at(20, 20));
  for (int i = 0; i < 99; ++i) fewer[static_cast<std::size_t>(2 * i)] = at(30, 20);
  HotPixelMask other({.width = 40, .height = 30, .learn_events = 901});
  for (int i = 0; i < 3; ++i) passed(other, fewer);
  EXPECT_EQ(other.pixels(), (Pixels{{20, 20}}));
  passed(other, Events(901, at(5, 6)));  // and again and again
  EXPECT_EQ(other.pixels(), (Pixels{{5, 6}, {20, 20}}));
}

TEST(HotPixelMask, WhatIsMaskedStaysUntilReset) {
  HotPixelMask mask({.width = 40, .height = 30, .pixels = {{1, 1}}, .learn_events = 100});
  EXPECT_EQ(mask.learn(repeated({{5, 6}}, 100)), 1U);
  passed(mask, repeated({{9, 9}}, 200));
  EXPECT_EQ(mask.pixels(), (Pixels{{1, 1}, {5, 6}, {9, 9}}));
  EXPECT_EQ(mask.learn({}), 0U);
  EXPECT_EQ(mask.learn(asap::test::wild_stream({}, 100)), 0U);
  EXPECT_EQ(mask.pixels().size(), 3U);
  passed(mask, repeated({{20, 9}}, 99));
  passed(mask, {at(40, 0)});
  mask.reset();
  EXPECT_EQ(mask.pixels(), (Pixels{{1, 1}}));
  EXPECT_EQ(mask.rejected(), 0U);
  passed(mask, repeated({{20, 9}}, 99));  // counted from nothing
  EXPECT_EQ(mask.pixels(), (Pixels{{1, 1}}));
}

TEST(HotPixelMask, MayWriteOverItsInput) {
  Events events = asap::test::wild_stream({}, 2000);
  HotPixelMask mask({.width = 40, .height = 30, .pixels = {{events[7].x, events[7].y}}});
  const Events expected = passed(mask, events);
  EXPECT_LT(expected.size(), events.size());
  events.resize(mask.process(events, events));
  EXPECT_EQ(events, expected);
}

TEST(HotPixelMask, DropsAndCountsEventsOutsideTheFrame) {
  HotPixelMask mask({.width = 9, .height = 5, .learn_events = 100});
  EXPECT_TRUE(passed(mask, repeated({{9, 4}, {8, 5}, {65535, 65535}}, 100)).empty());
  EXPECT_EQ(mask.rejected(), 300U);
  EXPECT_EQ(mask.learn(repeated({{9, 4}, {8, 5}, {65535, 65535}}, 100)), 0U);
  EXPECT_EQ(mask.pixels(), (Pixels{}));
}

TEST(HotPixelMask, OnlyPixelsCount) {
  Events odd;
  constexpr std::int64_t kStamps[] = {0, -1, std::numeric_limits<std::int64_t>::max(),
                                      std::numeric_limits<std::int64_t>::min()};
  for (const Event& event : asap::test::wild_stream({}, 1000)) {
    odd.push_back(event);
    odd.back().t = kStamps[odd.size() % 4];
    odd.back().p = static_cast<std::int16_t>(odd.size());
  }
  HotPixelMask mask({.width = 40, .height = 30, .learn_events = 100});
  EXPECT_EQ(passed(mask, odd), odd);
}

TEST(HotPixelMask, KeepIsCheckedAndWithoutEffect) {
  HotPixelMask mask({.width = 40, .height = 30, .learn_events = 100});
  mask.set_keep(0.1);
  passed(mask, repeated({{5, 6}}, 100));
  EXPECT_EQ(mask.pixels(), (Pixels{{5, 6}}));
  EXPECT_NO_THROW(mask.set_keep(0));
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(mask.set_keep(bad), std::invalid_argument);
  }
}

TEST(HotPixelMask, NamesBadParameters) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { HotPixelMask({.width = 9, .height = 0}); }),
            "height = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of([] { HotPixelMask({.width = 9, .height = 9, .pixels = {{0, 0}, {9, 0}}}); }),
            "pixels: x = 9: must lie in the frame");
  EXPECT_EQ(error_of([] { HotPixelMask({.width = 9, .height = 9, .pixels = {{0, -1}}}); }),
            "pixels: y = -1: must lie in the frame");
  EXPECT_EQ(error_of([] { HotPixelMask({.width = 9, .height = 9, .learn_events = -1}); }),
            "learn_events = -1: must be 0 to 10^9 events");
  EXPECT_EQ(
      error_of([] { HotPixelMask({.width = 9, .height = 9, .learn_events = 1'000'000'001}); }),
      "learn_events = 1000000001: must be 0 to 10^9 events");
}

TEST(HotPixelMask, ACopyGoesItsOwnWay) {
  const auto events = asap::test::golden_corner_stream(20'000);
  const Events first(events.begin(), events.begin() + 10'000);
  const Events second(events.begin() + 10'000, events.end());
  HotPixelMask mask({.width = 346, .height = 260, .learn_events = 1000});
  passed(mask, first);
  HotPixelMask copy = mask;
  HotPixelMask other({.width = 1, .height = 1});
  other = copy;
  HotPixelMask moved = std::move(copy);
  copy = other;  // what was moved from takes a new value
  const auto expected = passed(mask, second);
  for (HotPixelMask* each : {&moved, &other, &copy}) {
    EXPECT_EQ(passed(*each, second), expected);
    EXPECT_EQ(each->config().width, 346);
  }
}

TEST(HotPixelMask, AllocatesOnlyInTheConstructor) {
  const Events events = asap::test::golden_corner_stream(20'000);
  HotPixelMask mask({.width = 346, .height = 260, .learn_events = 1000});
  Events out(events.size());
  const std::size_t before = asap::test::allocations();
  mask.process(events, out);
  mask.learn(events);
  mask.set_keep(0.5);
  mask.reset();
  EXPECT_EQ(asap::test::allocations(), before);
}

}  // namespace
}  // namespace hot_pixel_mask_test
