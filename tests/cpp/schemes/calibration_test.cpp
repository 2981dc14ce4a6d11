#include "schemes/calibration.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace asap::calibration_test {
namespace {

TEST(Calibration, ASafeSizeKeepsTheTimeIfAllOfTheCostIsThatOfTheEvents) {
  EXPECT_EQ(safe_size(1000, 10), 101.0);
  EXPECT_EQ(safe_size(1000, 300), 4.0);
  EXPECT_EQ(safe_size(1000, 1e6), 2.0);
  EXPECT_EQ(safe_size(1000, std::numeric_limits<double>::infinity()), 2.0);
}

TEST(Calibration, WhatIsNotSafeWaits) {
  Decision planned = Decision::take(1000, 0.5);
  planned.stale = 7;
  EXPECT_EQ(safe_slice(planned, 500).keep, 0.5);
  const Decision slice = safe_slice(planned, 499);
  EXPECT_EQ(slice.raw, 499u);
  EXPECT_EQ(slice.keep, 1.0);
  EXPECT_EQ(slice.stale, 7u);
}

TEST(Calibration, AFixedCostThatRulesTheBoundOutIsLookedAt) {
  EXPECT_TRUE(is_single(31, 2.6e6, 10e6));
  EXPECT_FALSE(is_single(31, 2.4e6, 10e6));
  EXPECT_FALSE(is_single(30, 2.6e6, 10e6));
  EXPECT_FALSE(is_single(14, 2.6e6, 10e6)) << "an early one";
  EXPECT_TRUE(is_single(15, 2.6e6, 10e6));
}

}  // namespace
}  // namespace asap::calibration_test
