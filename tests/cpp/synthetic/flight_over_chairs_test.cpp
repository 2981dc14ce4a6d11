#include "asap/synthetic/streams.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "synthetic/scene_checks.hpp"

namespace asap::flight_over_chairs_test {
namespace {

using std::chrono::microseconds;

using test::all_events;
using test::fingerprint;
using test::rates_hz;

TEST(FlightOverChairs, RateGrowsAndStaysBelowThePapersBound) {
  for (const std::uint64_t seed : {0U, 1U, 2U, 3U, 4U}) {
    const FlightOverChairsConfig config{.seed = seed};
    const auto events = all_events<FlightOverChairs>(config);
    const auto coarse = rates_hz(events, 0, config.duration.count(), 500'000);
    EXPECT_LT(coarse.front(), 0.2e6);
    EXPECT_NEAR(coarse.back(), 1.8e6, 0.2 * 1.8e6);
    EXPECT_TRUE(std::ranges::is_sorted(coarse)) << seed;
    EXPECT_LT(std::ranges::max(rates_hz(events, 0, config.duration.count(), 10'000)), 5e6);
  }
}

TEST(FlightOverChairs, KeepsItsRateOnOtherSensorsAndDurations) {
  for (const FlightOverChairsConfig& config :
       {FlightOverChairsConfig{.width = 640, .height = 480, .duration = microseconds(16'000'000)},
        FlightOverChairsConfig{
            .width = 240, .height = 180, .duration = microseconds(12'000'000)}}) {
    const auto events = all_events<FlightOverChairs>(config);
    const auto rates = rates_hz(events, 0, config.duration.count(), config.duration.count() / 10);
    EXPECT_LT(rates.front(), 0.4e6);
    EXPECT_NEAR(rates.back(), 1.8e6, 0.3 * 1.8e6);
  }
}

// Blobs with space between them, for a clusterer: of the tiles of the view, few are busy early.
TEST(FlightOverChairs, FillsTheViewChairByChair) {
  const FlightOverChairsConfig config{.noise_hz = 0.0};
  const auto events = all_events<FlightOverChairs>(config);
  const auto busy_tiles = [&](std::int64_t from_us) {
    std::vector<int> per_tile(13 * 18);
    for (const Event& event : events) {
      if (event.t < from_us || event.t >= from_us + 20'000) continue;
      ++per_tile.at(static_cast<std::size_t>(event.y / 20 * 18 + event.x / 20));
    }
    return std::ranges::count_if(per_tile, [](int count) { return count > 0; });
  };
  EXPECT_GT(busy_tiles(100'000), 5);
  EXPECT_LT(busy_tiles(100'000), 60);
  EXPECT_GT(busy_tiles(3'900'000), 150);
}

// The same on every compiler and machine. A change of the stream changes published figures: say so
// in the changelog.
TEST(FlightOverChairs, FirstEventsAreGolden) {
  FlightOverChairs stream{{.seed = 1}};
  auto events = read_events(stream, 100'000);
  events.resize(100'000);
  EXPECT_EQ(fingerprint(events), 17972684643795974826U);
}

}  // namespace
}  // namespace asap::flight_over_chairs_test
