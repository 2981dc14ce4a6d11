#include "asap/algorithms/noise_filters.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
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

TEST(HotPixelMask, RefusesPixelsOutsideTheFrame) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { HotPixelMask({.width = 9, .height = 9, .pixels = {{0, 0}, {9, 0}}}); }),
            "pixels: x = 9: must lie in the frame");
  EXPECT_EQ(error_of([] { HotPixelMask({.width = 9, .height = 9, .pixels = {{0, -1}}}); }),
            "pixels: y = -1: must lie in the frame");
}

}  // namespace
}  // namespace hot_pixel_mask_test
