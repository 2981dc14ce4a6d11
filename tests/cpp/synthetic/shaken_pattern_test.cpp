#include "asap/synthetic/streams.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "synthetic/scene_checks.hpp"

namespace asap::shaken_pattern_test {
namespace {

using std::chrono::microseconds;

using test::all_events;
using test::fingerprint;
using test::rates_hz;

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

// The same on every compiler and machine. A change of the stream changes published figures: say so
// in the changelog.
TEST(ShakenPattern, FirstEventsAreGolden) {
  ShakenPattern stream{{.seed = 1}};
  auto events = read_events(stream, 100'000);
  events.resize(100'000);
  EXPECT_EQ(fingerprint(events), 8434657412468591069U);
}

}  // namespace
}  // namespace asap::shaken_pattern_test
