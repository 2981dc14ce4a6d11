#include "asap/synthetic/streams.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <string>

#include "synthetic/scene_checks.hpp"

namespace asap::flight_over_chairs_test {
namespace {

using std::chrono::microseconds;

using test::all_events;
using test::expect_well_formed;
using test::fingerprint;
using test::rates_hz;

TEST(FlightOverChairs, IsWellFormed) {
  for (const FlightOverChairsConfig& config :
       {FlightOverChairsConfig{},
        FlightOverChairsConfig{.width = 120,
                               .height = 700,
                               .duration = microseconds(3'000'001),
                               .start = microseconds(77),
                               .chair_px = 60.0,
                               .seed = 3},
        FlightOverChairsConfig{.width = 16,
                               .height = 16,
                               .duration = microseconds(10'000),
                               .start = microseconds(-5),
                               .last_rate_hz = 25'600,
                               .chair_px = 8.0,
                               .noise_hz = 1000.0}}) {
    expect_well_formed(all_events<FlightOverChairs>(config), config);
  }
}

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

TEST(FlightOverChairs, SeedDecidesAndStartShifts) {
  const FlightOverChairsConfig config{.duration = microseconds(500'000), .seed = 11};
  const auto events = all_events<FlightOverChairs>(config);
  EXPECT_EQ(all_events<FlightOverChairs>(config), events);
  EXPECT_NE(all_events<FlightOverChairs>(
                FlightOverChairsConfig{.duration = microseconds(500'000), .seed = 12}),
            events);

  auto later = all_events<FlightOverChairs>(FlightOverChairsConfig{
      .duration = microseconds(500'000), .start = microseconds(1'000'000'007), .seed = 11});
  for (Event& event : later) event.t -= 1'000'000'007;
  EXPECT_EQ(later, events);
}

TEST(FlightOverChairs, DoesNotDependOnHowItIsRead) {
  const FlightOverChairsConfig config{};
  const auto events = all_events<FlightOverChairs>(config);
  FlightOverChairs stream{config};
  std::vector<Event> joined;
  for (auto part = read_events(stream, 1000); !part.empty(); part = read_events(stream, 1000)) {
    joined.insert(joined.end(), part.begin(), part.end());
  }
  EXPECT_EQ(joined, events);
  EXPECT_TRUE(stream.next().empty());
}

// The same on every compiler and machine. A change of the stream changes published figures: say so
// in the changelog.
TEST(FlightOverChairs, FirstEventsAreGolden) {
  FlightOverChairs stream{{.seed = 1}};
  auto events = read_events(stream, 100'000);
  events.resize(100'000);
  EXPECT_EQ(fingerprint(events), 17972684643795974826U);
}

TEST(FlightOverChairs, RefusesABadConfiguration) {
  const auto refused = [](const FlightOverChairsConfig& config, const std::string& field) {
    try {
      const FlightOverChairs stream{config};
      ADD_FAILURE() << "accepted a bad " << field;
    } catch (const std::invalid_argument& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(field + " = ")) << error.what();
    }
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  refused({.width = 15}, "width");
  refused({.height = -1}, "height");
  refused({.duration = microseconds(9'999)}, "duration_us");
  refused({.start = microseconds(std::numeric_limits<std::int64_t>::min())}, "t0_us");
  refused({.last_rate_hz = 0.0}, "last_rate_hz");
  refused({.last_rate_hz = 9e6}, "last_rate_hz");
  refused({.chair_px = 7.0}, "chair_px");
  refused({.chair_px = nan}, "chair_px");
  refused({.noise_hz = nan}, "noise_hz");
}

}  // namespace
}  // namespace asap::flight_over_chairs_test
