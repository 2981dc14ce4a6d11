#include "asap/algorithms/event_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_surfaces.hpp"

namespace event_surface_test {
namespace {

using asap::Event;
using asap::SpeedInvariantTimeSurface;
using asap::ThresholdOrdinalSurface;

template <class Surface>
std::vector<int> values_of(const Surface& surface) {
  const auto [width, height, unused] = surface.config();
  std::vector<typename Surface::Value> values(static_cast<std::size_t>(width * height));
  surface.copy_to(values);
  return {values.begin(), values.end()};
}

template <class Surface>
void expect_golden(int sum, int set) {
  Surface surface({.width = 346, .height = 260});
  surface.process(asap::test::golden_corner_stream());
  const auto values = values_of(surface);
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0), sum);
  EXPECT_EQ(std::count(values.begin(), values.end(), 0), 346 * 260 - set);
}

TEST(EventSurface, GoldenVectors) {
  expect_golden<ThresholdOrdinalSurface>(3'701'507, 14'803);
  expect_golden<SpeedInvariantTimeSurface>(3'538'452, 32'952);
}

// `reach` is the size of the neighbourhood in the configuration.
template <class Surface, class Naive>
void expect_the_definition(int reach) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 3'000);
    Surface surface({wild.width, wild.height, reach});
    Naive naive(wild.width, wild.height, reach);
    // The naive form of a huge neighbourhood costs 65 000 pixels per event.
    const std::size_t count = reach == 127 ? 300 : events.size();
    for (std::size_t i = 0; i < count; ++i) {
      surface.process({&events[i], 1});
      naive.update(events[i]);
      if (i % 100 == 99) {
        ASSERT_EQ(values_of(surface), naive.values()) << wild.seed << ' ' << reach << ' ' << i;
      }
    }
  }
}

TEST(EventSurface, AgreesWithTheDefinition) {
  for (const int side : {3, 7, 15, 17, 127}) {
    expect_the_definition<ThresholdOrdinalSurface, asap::test::NaiveThresholdOrdinalSurface>(side);
  }
  for (const int radius : {1, 3, 4, 6, 127}) {
    expect_the_definition<SpeedInvariantTimeSurface, asap::test::NaiveSpeedInvariantTimeSurface>(
        radius);
  }
}

}  // namespace
}  // namespace event_surface_test
