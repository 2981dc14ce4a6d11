#include "asap/core/time.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace asap::time_test {
namespace {

constexpr std::int64_t kUnix_us = 1'600'000'000'123'456;

TEST(FloorDiv, RoundsDownOnBothSidesOfZero) {
  EXPECT_EQ(floor_div(0, 3), 0);
  EXPECT_EQ(floor_div(2, 3), 0);
  EXPECT_EQ(floor_div(3, 3), 1);
  EXPECT_EQ(floor_div(-1, 3), -1);
  EXPECT_EQ(floor_div(-3, 3), -1);
  EXPECT_EQ(floor_div(-4, 3), -2);
  EXPECT_EQ(floor_div(kLongAgo, 1), kLongAgo);
}

TEST(TimeAxis, BeginsAtTheWholeSecondBeforeTheFirstStamp) {
  EXPECT_EQ(TimeAxis(0, 1.0).to_ns(0), 0);
  EXPECT_EQ(TimeAxis(999'999, 1.0).to_ns(999'999), 999'999'000);
  EXPECT_EQ(TimeAxis(1'000'000, 1.0).to_ns(1'000'000), 0);
  EXPECT_EQ(TimeAxis(kUnix_us, 1.0).to_ns(kUnix_us), 123'456'000);
  EXPECT_EQ(TimeAxis(-1, 1.0).to_ns(-1), 999'999'000);
}

TEST(TimeAxis, KeepsEveryMicrosecondApart) {
  const TimeAxis axis(kUnix_us, 1.0);
  for (std::int64_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(axis.to_ns(kUnix_us + i) - axis.to_ns(kUnix_us), 1000 * i);
    EXPECT_EQ(axis.to_us(axis.to_ns(kUnix_us + i)), static_cast<double>(kUnix_us + i));
  }
}

TEST(TimeAxis, DividesTimeBySpeed) {
  const TimeAxis twice(10'000'000, 2.0);
  EXPECT_EQ(twice.to_ns(10'000'100), 50'000);
  EXPECT_EQ(twice.to_us(50'000), 10'000'100.0);
  EXPECT_EQ(TimeAxis(0, 0.001).to_ns(7), 7'000'000);
}

TEST(TimeAxis, SaturatesInsteadOfOverflowing) {
  const TimeAxis slow(0, 0.001);
  const volatile std::int64_t far = std::int64_t{1} << 52;  // not to be folded by the compiler
  EXPECT_GT(slow.to_ns(far), 9'000'000'000'000'000'000);
  EXPECT_LT(slow.to_ns(-far), -9'000'000'000'000'000'000);
}

}  // namespace
}  // namespace asap::time_test
