#include "asap/runner/linear_cost.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "support/errors.hpp"

namespace asap {
namespace {

TEST(LinearCost, WithoutNoiseIsALine) {
  const LinearCost cost({.alpha_us = 100, .beta_ns = 300});
  for (const std::uint64_t index : {0u, 1u, 99u}) {
    EXPECT_EQ(cost.processing_ns(index, 0), 100'000);
    EXPECT_EQ(cost.processing_ns(index, 1), 100'300);
    EXPECT_EQ(cost.processing_ns(index, 1'000'000), 300'100'000);
  }
}

TEST(LinearCost, IsAtLeastANanosecond) {
  EXPECT_EQ(LinearCost({.alpha_us = 0, .beta_ns = 0}).processing_ns(0, 5), 1);
  EXPECT_EQ(LinearCost({.alpha_us = 0, .beta_ns = 0.1}).processing_ns(0, 1), 1);
}

TEST(LinearCost, TheNoiseHasMeanOne) {
  constexpr int kCount = 200'000;
  for (const double noise : {0.1, 0.5, 1.0}) {
    const LinearCost cost({.alpha_us = 1000, .beta_ns = 0, .noise = noise, .seed = 4});
    double sum = 0;
    double sum_of_logs = 0;
    double squares_of_logs = 0;
    for (std::uint64_t i = 0; i < kCount; ++i) {
      const double factor = static_cast<double>(cost.processing_ns(i, 1)) / 1e6;
      sum += factor;
      sum_of_logs += std::log(factor);
      squares_of_logs += std::log(factor) * std::log(factor);
    }
    const double deviation = std::sqrt(std::expm1(noise * noise));
    EXPECT_NEAR(sum / kCount, 1.0, 4 * deviation / std::sqrt(kCount)) << noise;
    const double mean_log = sum_of_logs / kCount;
    EXPECT_NEAR(mean_log, -noise * noise / 2, 4 * noise / std::sqrt(kCount));
    EXPECT_NEAR(std::sqrt(squares_of_logs / kCount - mean_log * mean_log), noise, 0.01 * noise);
  }
}

TEST(LinearCost, IsAFunctionOfSeedAndIndex) {
  const LinearCost one({.noise = 0.5, .seed = 1});
  const LinearCost same({.noise = 0.5, .seed = 1});
  const LinearCost other({.noise = 0.5, .seed = 2});
  int differ = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    EXPECT_EQ(one.processing_ns(99 - i, 10), same.processing_ns(99 - i, 10));
    differ += one.processing_ns(i, 10) != other.processing_ns(i, 10) ? 1 : 0;
  }
  EXPECT_GT(differ, 95);
}

TEST(LinearCost, RefusesABadConfigurationByName) {
  const auto error = [](LinearCostConfig config) {
    return test::error_of([=] { LinearCost cost(config); });
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error({.alpha_us = -1}), "alpha_us = -1: must be between 0 and 1e9 us");
  EXPECT_EQ(error({.alpha_us = kNaN}), "alpha_us = nan: must be between 0 and 1e9 us");
  EXPECT_EQ(error({.beta_ns = 2e9}), "beta_ns = 2000000000: must be between 0 and 1e9 ns");
  EXPECT_EQ(error({.noise = -0.5}), "noise = -0.5: must be between 0 and 5");
  EXPECT_EQ(error({.noise = kNaN}), "noise = nan: must be between 0 and 5");
}

}  // namespace
}  // namespace asap
