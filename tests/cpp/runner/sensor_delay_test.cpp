#include "runner/sensor_delay.hpp"

#include <gtest/gtest.h>

namespace asap::sensor_delay_test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kSecond = 1000 * kMillisecond;

TEST(SensorDelay, IsWhatComesOnTopOfTheLeast) {
  SensorDelay delay;
  delay.note(1'000'000, 77 * kSecond);  // clocks of their own
  EXPECT_EQ(delay.last_ns(), 0);
  delay.note(1'010'000, 77 * kSecond + 13 * kMillisecond);
  EXPECT_EQ(delay.last_ns(), 3 * kMillisecond);
  delay.note(1'020'000, 77 * kSecond + 19 * kMillisecond);
  EXPECT_EQ(delay.last_ns(), 0) << "the least so far";
  delay.note(1'030'000, 77 * kSecond + 30 * kMillisecond);
  EXPECT_EQ(delay.last_ns(), 1 * kMillisecond);
  EXPECT_EQ(delay.max_ns(), 3 * kMillisecond);
}

// The host's clock is 200 ppm faster: after an hour they are 0.7 s apart.
TEST(SensorDelay, SkewIsForgotten) {
  SensorDelay delay;
  for (std::int64_t ms = 0; ms < 3'600'000; ms += 10) {
    delay.note(1000 * ms, ms * kMillisecond + ms * 200);
    ASSERT_LE(delay.last_ns(), 2 * kMillisecond);
    ASSERT_GE(delay.last_ns(), 0);
  }
  EXPECT_GE(delay.max_ns(), kMillisecond) << "200 ppm of 5 s and more";
}

TEST(SensorDelay, RemembersTheLeastForAWindow) {
  SensorDelay delay;
  delay.note(0, 0);
  for (std::int64_t ms = 10; ms < 9'000; ms += 10) {  // from now on 4 ms late
    delay.note(1000 * ms, (ms + 4) * kMillisecond);
    ASSERT_EQ(delay.last_ns(), 4 * kMillisecond) << ms;
  }
  delay.note(20'000'000, 20'004 * kMillisecond);
  delay.note(26'000'000, 26'004 * kMillisecond);
  EXPECT_EQ(delay.last_ns(), 0) << "it has become the rule";
}

TEST(SensorDelay, StampsMayBeNegative) {  // a run's axis begins where they do
  SensorDelay delay;
  delay.note(-5'000'000, -5 * kSecond);
  delay.note(-4'990'000, -5 * kSecond + 13 * kMillisecond);
  EXPECT_EQ(delay.last_ns(), 3 * kMillisecond);
}

TEST(SensorDelay, AClockSetBackBeginsAnew) {
  SensorDelay delay;
  delay.note(50'000'000, 0);
  delay.forget();
  delay.note(0, kSecond);
  EXPECT_EQ(delay.last_ns(), 0);
  EXPECT_EQ(delay.max_ns(), 0);
}

}  // namespace
}  // namespace asap::sensor_delay_test
