#include "asap/schemes/calibration.hpp"

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

TEST(Calibration, AFixedCostThatRulesTheBoundOutIsLookedAt) {
  EXPECT_TRUE(is_single(31, 2.6e6, 10e6));
  EXPECT_FALSE(is_single(31, 2.4e6, 10e6));
  EXPECT_FALSE(is_single(30, 2.6e6, 10e6));
  EXPECT_FALSE(is_single(14, 2.6e6, 10e6)) << "an early one";
  EXPECT_TRUE(is_single(15, 2.6e6, 10e6));
}

}  // namespace
}  // namespace asap::calibration_test
