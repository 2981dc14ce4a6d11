#include "asap/algorithms/threshold_ordinal_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_surfaces.hpp"
#include "support/errors.hpp"

namespace threshold_ordinal_surface_test {
namespace {

using asap::Event;
using asap::ThresholdOrdinalSurface;

std::vector<int> values_of(const ThresholdOrdinalSurface& surface) {
  const auto [width, height, unused] = surface.config();
  std::vector<ThresholdOrdinalSurface::Value> values(static_cast<std::size_t>(width * height));
  surface.copy_to(values);
  return {values.begin(), values.end()};
}

TEST(ThresholdOrdinalSurface, GoldenVector) {
  ThresholdOrdinalSurface surface({.width = 346, .height = 260});
  surface.process(asap::test::golden_corner_stream());
  const auto values = values_of(surface);
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0), 3'701'507);
  EXPECT_EQ(std::count(values.begin(), values.end(), 0), 346 * 260 - 14'803);
}

TEST(ThresholdOrdinalSurface, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 3'000);
    for (const int side : {3, 7, 15, 17, 127}) {
      ThresholdOrdinalSurface surface({.width = wild.width, .height = wild.height, .side = side});
      asap::test::NaiveThresholdOrdinalSurface naive(wild.width, wild.height, side);
      // The naive form of a huge neighbourhood costs 65 000 pixels per event.
      const std::size_t count = side == 127 ? 300 : events.size();
      for (std::size_t i = 0; i < count; ++i) {
        surface.process({&events[i], 1});
        naive.update(events[i]);
        if (i % 100 == 99) {
          ASSERT_EQ(values_of(surface), naive.values()) << wild.seed << ' ' << side << ' ' << i;
        }
      }
    }
  }
}

TEST(ThresholdOrdinalSurface, APixelLastsForTwoSidesOfEvents) {
  ThresholdOrdinalSurface surface({.width = 9, .height = 9, .side = 5});
  const Event old{.x = 4, .y = 4, .p = 0, .t = 0};
  const Event near{.x = 6, .y = 2, .p = 0, .t = 0};
  const Event far{.x = 7, .y = 4, .p = 0, .t = 0};
  surface.process({&old, 1});
  surface.process({&far, 1});
  EXPECT_EQ(surface.at(4, 4), 255);
  for (int lower = 254; lower >= 245; --lower) {
    surface.process({&near, 1});
    EXPECT_EQ(surface.at(4, 4), lower);
  }
  surface.process({&near, 1});
  EXPECT_EQ(surface.at(4, 4), 0);
  surface.process({&near, 1});
  EXPECT_EQ(surface.at(4, 4), 0);
}

TEST(ThresholdOrdinalSurface, NamesBadParameters) {
  using asap::test::error_of;
  for (const int bad : {-7, 1, 8, 129}) {
    EXPECT_EQ(error_of([&] { ThresholdOrdinalSurface({.width = 9, .height = 9, .side = bad}); }),
              "side = " + std::to_string(bad) + ": must be odd, 3 to 127 px");
  }
}

}  // namespace
}  // namespace threshold_ordinal_surface_test
