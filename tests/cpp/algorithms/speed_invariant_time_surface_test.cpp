#include "asap/algorithms/speed_invariant_time_surface.hpp"

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

namespace speed_invariant_time_surface_test {
namespace {

using asap::Event;
using asap::SpeedInvariantTimeSurface;

std::vector<int> values_of(const SpeedInvariantTimeSurface& surface) {
  const auto [width, height, unused] = surface.config();
  std::vector<SpeedInvariantTimeSurface::Value> values(static_cast<std::size_t>(width * height));
  surface.copy_to(values);
  return {values.begin(), values.end()};
}

TEST(SpeedInvariantTimeSurface, GoldenVector) {
  SpeedInvariantTimeSurface surface({.width = 346, .height = 260});
  surface.process(asap::test::golden_corner_stream());
  const auto values = values_of(surface);
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0), 3'538'452);
  EXPECT_EQ(std::count(values.begin(), values.end(), 0), 346 * 260 - 32'952);
}

TEST(SpeedInvariantTimeSurface, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 3'000);
    for (const int radius : {1, 3, 4, 6, 127}) {
      SpeedInvariantTimeSurface surface(
          {.width = wild.width, .height = wild.height, .radius = radius});
      asap::test::NaiveSpeedInvariantTimeSurface naive(wild.width, wild.height, radius);
      // The naive form of a huge neighbourhood costs 65 000 pixels per event.
      const std::size_t count = radius == 127 ? 300 : events.size();
      for (std::size_t i = 0; i < count; ++i) {
        surface.process({&events[i], 1});
        naive.update(events[i]);
        if (i % 100 == 99) {
          ASSERT_EQ(values_of(surface), naive.values()) << wild.seed << ' ' << radius << ' ' << i;
        }
      }
    }
  }
}

TEST(SpeedInvariantTimeSurface, RanksPixelsByTheirLastEvent) {
  SpeedInvariantTimeSurface surface({.width = 9, .height = 9, .radius = 1});
  const Event a{.x = 4, .y = 4, .p = 0, .t = 0};
  const Event b{.x = 5, .y = 4, .p = 0, .t = 0};
  const Event c{.x = 4, .y = 5, .p = 0, .t = 0};
  for (const Event& event : {a, b, c}) surface.process({&event, 1});
  EXPECT_EQ(surface.at(4, 4), 7);
  EXPECT_EQ(surface.at(5, 4), 8);
  EXPECT_EQ(surface.at(4, 5), 9);
  surface.process({&b, 1});  // lowers what ranked above it, and nothing else
  EXPECT_EQ(surface.at(4, 4), 7);
  EXPECT_EQ(surface.at(5, 4), 9);
  EXPECT_EQ(surface.at(4, 5), 8);
}

TEST(SpeedInvariantTimeSurface, NamesBadParameters) {
  using asap::test::error_of;
  for (const int bad : {-1, 0, 128}) {
    EXPECT_EQ(
        error_of([&] { SpeedInvariantTimeSurface({.width = 9, .height = 9, .radius = bad}); }),
        "radius = " + std::to_string(bad) + ": must be 1 to 127 px");
  }
}

}  // namespace
}  // namespace speed_invariant_time_surface_test
