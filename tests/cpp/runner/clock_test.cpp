#include "runner/clock.hpp"

#include <gtest/gtest.h>

namespace asap::clock_test {
namespace {

TEST(RunClock, GoesOnFromWhereItIsStarted) {
  RunClock clock;
  clock.start(5'000'000'000);
  const std::int64_t first = clock.now_ns();
  const std::int64_t second = clock.now_ns();
  EXPECT_GE(first, 5'000'000'000);
  EXPECT_LT(first, 65'000'000'000);
  EXPECT_GE(second, first);
}

TEST(RunClock, WhenIsTheInverseOfNow) {
  RunClock clock;
  clock.start(123);
  const auto before = RunClock::Steady::now();
  const auto when = clock.when(clock.now_ns());
  const auto after = RunClock::Steady::now();
  EXPECT_GE(when, before);
  EXPECT_LE(when, after);
  EXPECT_EQ(clock.when(kNever), RunClock::Steady::time_point::max());
}

}  // namespace
}  // namespace asap::clock_test
