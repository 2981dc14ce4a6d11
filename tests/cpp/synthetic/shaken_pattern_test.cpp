#include "asap/synthetic/streams.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "synthetic/scene_checks.hpp"

namespace asap::shaken_pattern_test {
namespace {

using std::chrono::microseconds;

using test::all_events;
using test::expect_well_formed;
using test::fingerprint;
using test::rates_hz;

TEST(ShakenPattern, IsWellFormed) {
  for (const ShakenPatternConfig& config :
       {ShakenPatternConfig{.duration = microseconds(500'000)},
        ShakenPatternConfig{.width = 64,
                            .height = 48,
                            .duration = microseconds(123'457),
                            .start = microseconds(-1'000),
                            .last_rate_hz = 1e6,
                            .amplitude_px = 4.0,
                            .seed = 5},
        ShakenPatternConfig{.width = 16,
                            .height = 16,
                            .duration = microseconds(10'000),
                            .start = microseconds(std::int64_t{1} << 62),
                            .first_rate_hz = 128'000,
                            .last_rate_hz = 128'000,
                            .amplitude_px = 1000.0}}) {
    expect_well_formed(all_events<ShakenPattern>(config), config);
  }
}

TEST(ShakenPattern, RateClimbsFromATenthToThirteenMillion) {
  for (const std::uint64_t seed : {0U, 1U}) {
    const ShakenPatternConfig config{.seed = seed};
    const auto events = all_events<ShakenPattern>(config);
    EXPECT_GT(events.size(), 24'000'000U);
    EXPECT_LT(events.size(), 30'000'000U);
    const auto rates = rates_hz(events, 0, config.duration.count(), 100'000);
    EXPECT_LT(rates.front(), 0.2e6);
    EXPECT_GT(rates.back(), 12e6);
    for (std::size_t i = 0; i < rates.size(); ++i) {
      const double progress = (static_cast<double>(i) + 0.5) / static_cast<double>(rates.size());
      const double print_hz = 0.1e6 + 12.9e6 * std::pow(progress, 1.5);
      const double noise_hz = 0.1 * 346 * 260;
      EXPECT_NEAR(rates[i], print_hz + noise_hz, 0.12 * print_hz) << i;
    }
  }
}

TEST(ShakenPattern, PulsesStayMild) {
  const ShakenPatternConfig config{
      .duration = microseconds(500'000), .first_rate_hz = 6e6, .last_rate_hz = 6e6};
  for (const double rate :
       rates_hz(all_events<ShakenPattern>(config), 0, config.duration.count(), 5'000)) {
    EXPECT_NEAR(rate, 6e6, 0.25 * 6e6);
  }
}

TEST(ShakenPattern, CoversTheWholeSensor) {
  const ShakenPatternConfig config{
      .duration = microseconds(500'000), .first_rate_hz = 6e6, .last_rate_hz = 6e6};
  std::vector<int> per_tile(10 * 10);
  for (const Event& event : all_events<ShakenPattern>(config)) {
    ++per_tile.at(
        static_cast<std::size_t>(event.x * 10 / config.width * 10 + event.y * 10 / config.height));
  }
  for (const int count : per_tile) EXPECT_NEAR(count, 30'000, 20'000);
}

TEST(ShakenPattern, SeedDecidesAndStartShifts) {
  const ShakenPatternConfig config{.duration = microseconds(200'000), .seed = 11};
  const auto events = all_events<ShakenPattern>(config);
  EXPECT_EQ(all_events<ShakenPattern>(config), events);
  EXPECT_NE(
      all_events<ShakenPattern>(ShakenPatternConfig{.duration = microseconds(200'000), .seed = 12}),
      events);

  auto later = all_events<ShakenPattern>(ShakenPatternConfig{
      .duration = microseconds(200'000), .start = microseconds(1'000'000'007), .seed = 11});
  for (Event& event : later) event.t -= 1'000'000'007;
  EXPECT_EQ(later, events);
}

TEST(ShakenPattern, DoesNotDependOnHowItIsRead) {
  const ShakenPatternConfig config{.duration = microseconds(200'000)};
  const auto events = all_events<ShakenPattern>(config);
  ShakenPattern stream{config};
  std::vector<Event> joined;
  for (auto part = read_events(stream, 1000); !part.empty(); part = read_events(stream, 1000)) {
    joined.insert(joined.end(), part.begin(), part.end());
  }
  EXPECT_EQ(joined, events);
  EXPECT_TRUE(stream.next().empty());
}

// The same on every compiler and machine. A change of the stream changes published figures: say so
// in the changelog.
TEST(ShakenPattern, FirstEventsAreGolden) {
  ShakenPattern stream{{.seed = 1}};
  auto events = read_events(stream, 100'000);
  events.resize(100'000);
  EXPECT_EQ(fingerprint(events), 8434657412468591069U);
}

TEST(ShakenPattern, RefusesABadConfiguration) {
  const auto refused = [](const ShakenPatternConfig& config, const std::string& field) {
    try {
      const ShakenPattern stream{config};
      ADD_FAILURE() << "accepted a bad " << field;
    } catch (const std::invalid_argument& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(field + " = ")) << error.what();
    }
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  refused({.width = 0}, "width");
  refused({.height = 8193}, "height");
  refused({.duration = microseconds(0)}, "duration_us");
  refused({.start = microseconds(std::numeric_limits<std::int64_t>::max())}, "t0_us");
  refused({.first_rate_hz = 0.0}, "first_rate_hz");
  refused({.first_rate_hz = 14e6}, "first_rate_hz");
  refused({.last_rate_hz = 46e6}, "last_rate_hz");
  refused({.last_rate_hz = nan}, "last_rate_hz");
  refused({.amplitude_px = 3.9}, "amplitude_px");
  refused({.noise_hz = -1.0}, "noise_hz");
}

}  // namespace
}  // namespace asap::shaken_pattern_test
