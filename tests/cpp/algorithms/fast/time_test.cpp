#include "algorithms/fast/time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace asap::fast::time_test {
namespace {

// ---- stamps ----

TEST(Stamp, AgesAreDifferencesAcrossTheWrap) {
  EXPECT_EQ(age_us(5, 0xfffffffbU), 10);
  EXPECT_EQ(age_us(0xfffffffbU, 5), -10);
  EXPECT_EQ(age_us(3, long_before(3)), kLongAgo_us);
}

TEST(Scrubber, VisitsEveryEntryOncePerRound) {
  for (const std::uint64_t step_us : {2'000ULL, 1'234'567ULL, 400'000'000ULL}) {
    Scrubber scrubber(1000);
    std::vector<int> visits(1000);
    const auto count = [&](std::size_t first, std::size_t n) {
      for (std::size_t i = first; i < first + n; ++i) ++visits.at(i);
    };
    for (std::uint64_t t = 0; t < Scrubber::kRound_us; t += step_us) {
      scrubber.advance(std::min(step_us, Scrubber::kRound_us - t), count);
    }
    EXPECT_EQ(visits, std::vector<int>(1000, 1)) << step_us;
  }
}

TEST(Scrubber, ASilenceOfAnyLengthVisitsAllOnce) {
  Scrubber scrubber(10);
  std::size_t visits = 0;
  scrubber.advance(~std::uint64_t{0}, [&](std::size_t, std::size_t n) { visits += n; });
  EXPECT_EQ(visits, 10U);
}

TEST(Scrub, KeepsOldEntriesOldForHours) {
  std::vector<Stamp> stamps{0};
  Scrubber scrubber(stamps.size());
  std::uint64_t now_us = 0;
  for (int hour = 0; hour < 40; ++hour) {
    now_us += 300'000'000;
    const auto now = static_cast<Stamp>(now_us);
    scrubber.advance(300'000'000, [&](std::size_t first, std::size_t n) {
      scrub(stamps.data() + first, n, now, [](Stamp& s) -> Stamp& { return s; });
    });
    EXPECT_GE(age_us(now, stamps[0]), 300'000'000);
  }
}

// ---- the clock ----

TEST(EventClock, AStampThatGoesBackALittleCountsAsTheLatest) {
  EventClock clock;
  clock.advance(100);
  const auto start = clock.now_us();
  clock.advance(150);
  clock.advance(120);
  EXPECT_EQ(clock.now_us() - start, 50U);
  EXPECT_EQ(clock.latest_us(), 150);
  clock.advance(160);
  EXPECT_EQ(clock.now_us() - start, 60U);
}

TEST(EventClock, ALargeBackStepBeginsANewEpoch) {
  EventClock clock;
  clock.advance(4'294'967'295);
  const auto start = clock.now_us();
  clock.advance(7);
  EXPECT_EQ(clock.now_us(), start);
  EXPECT_EQ(clock.latest_us(), 7);
  clock.advance(1007);
  EXPECT_EQ(clock.now_us() - start, 1000U);
}

TEST(EventClock, AStampIsNeverBeforeTheFirstNorAfterTheLast) {
  constexpr std::int64_t kFirst_us = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLast_us = std::numeric_limits<std::int64_t>::max();
  EventClock clock;
  clock.advance(kFirst_us + 10);
  EXPECT_EQ(clock.stamp_us(0), kFirst_us + 10);
  EXPECT_EQ(clock.stamp_us(7), kFirst_us + 3);
  EXPECT_EQ(clock.stamp_us(68), kFirst_us);
  EXPECT_EQ(clock.stamp_us(-5), kFirst_us + 15);
  clock.advance(kLast_us - 10);
  EXPECT_EQ(clock.stamp_us(-7), kLast_us - 3);
  EXPECT_EQ(clock.stamp_us(-68), kLast_us);
}

TEST(EventClock, ABackStepOfASecondIsStillLate) {
  EventClock clock;
  clock.advance(2'000'000);
  clock.advance(1'000'000);
  EXPECT_EQ(clock.latest_us(), 2'000'000);
  clock.advance(999'999);
  EXPECT_EQ(clock.latest_us(), 999'999);
}

TEST(EventClock, TakesAnyStamps) {
  EventClock clock;
  clock.advance(std::numeric_limits<std::int64_t>::min());
  const auto start = clock.now_us();
  clock.advance(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(clock.now_us() - start, std::numeric_limits<std::uint64_t>::max());
  clock.advance(std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(clock.latest_us(), std::numeric_limits<std::int64_t>::min());
}

TEST(EventClock, TimeWithoutAnEventNeverGoesBack) {
  EventClock clock;
  clock.advance(10'000'000);
  clock.advance_to(1);
  EXPECT_EQ(clock.latest_us(), 10'000'000);
  clock.advance_to(10'000'005);
  EXPECT_EQ(clock.latest_us(), 10'000'005);
}

// ---- exponential decay ----

TEST(Decay, IsTheExponential) {
  EXPECT_EQ(decay(0), 1);
  for (float u = 0.001F; u < 30; u *= 1.1F) {
    EXPECT_NEAR(decay(u) / std::exp(-u), 1, u < 12 ? 2e-5 : 1e-3) << u;
  }
}

TEST(Decay, StaysPositiveAndFinite) {
  EXPECT_GT(decay(1e30F), 0);
  EXPECT_LT(decay(1e30F), 1e-30F);
}

TEST(Logarithm, IsTheNaturalOne) {
  for (float y = 0.5F; y < 1000; y *= 1.1F) {
    EXPECT_NEAR(logarithm(y), std::log(y), 1e-5) << y;
  }
  EXPECT_GT(logarithm(1e38F), 60);
}

TEST(LowPassWeight, IsTheMeanOverTheAgeAtFirst) {
  EXPECT_EQ(low_pass_weight(decay(0.1F), 1, 1), 1);
  EXPECT_EQ(low_pass_weight(decay(0.1F), 1, 2), 0.5F);
  EXPECT_EQ(low_pass_weight(decay(0.1F), 1, 1000), 1 - decay(0.1F));
}

}  // namespace
}  // namespace asap::fast::time_test
