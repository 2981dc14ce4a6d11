#include "algorithms/fast/event_clock.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace event_clock_test {
namespace {

using asap::fast::EventClock;

TEST(EventClock, StampsThatGoBackALittleCountAsTheLatest) {
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

}  // namespace
}  // namespace event_clock_test
