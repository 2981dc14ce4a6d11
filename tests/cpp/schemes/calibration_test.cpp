#include "asap/schemes/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace asap::calibration_test {
namespace {

TEST(Calibration, SizesDoubleOverTheFirstFifteenPackages) {
  EXPECT_EQ(slow_start_size(0), 2.0);
  EXPECT_EQ(slow_start_size(1), 4.0);
  EXPECT_EQ(slow_start_size(14), 32768.0);
  EXPECT_TRUE(is_early(14));
  EXPECT_FALSE(is_early(15));
  for (const std::uint64_t index : {15u, 16u, 64u, 1'000'000u}) {
    EXPECT_TRUE(std::isinf(slow_start_size(index)));
  }
}

TEST(Calibration, ASafeSizeKeepsTheBudgetIfAllOfTheCostIsThatOfTheEvents) {
  EXPECT_EQ(safe_size(1000, 10), 100.0);
  EXPECT_EQ(safe_size(1000, 300), 3.0);
  EXPECT_EQ(safe_size(1000, 1e6), 2.0);
  EXPECT_EQ(safe_size(1000, std::numeric_limits<double>::infinity()), 2.0);
}

TEST(Calibration, EverySixteenthPackageAfterwardsIsDithered) {
  std::vector<std::uint64_t> dithered;
  for (std::uint64_t index = 0; index < 50; ++index) {
    if (is_dithered(index)) dithered.push_back(index);
  }
  EXPECT_EQ(dithered, (std::vector<std::uint64_t>{15, 31, 47}));
}

TEST(Calibration, AFixedCostThatRulesTheBoundOutIsLookedAt) {
  EXPECT_TRUE(is_single(31, 2.6e6, 10e6));
  EXPECT_FALSE(is_single(31, 2.4e6, 10e6));
  EXPECT_FALSE(is_single(30, 2.6e6, 10e6));
}

}  // namespace
}  // namespace asap::calibration_test
