#include "study/busy_wait.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap::busy_wait_test {
namespace {

using Clock = std::chrono::steady_clock;

TEST(BusyWait, TakesAtLeastWhatItSays) {
  BusyWait algorithm({.alpha_us = 300, .beta_ns = 2000});
  const auto start = Clock::now();
  algorithm.begin();
  const auto begun = Clock::now();
  algorithm.process(test::evenly_spaced(100, 1));
  EXPECT_GE(begun - start, std::chrono::microseconds(300));
  EXPECT_GE(Clock::now() - begun, std::chrono::microseconds(200));
}

TEST(BusyWait, RefusesABadConfigurationByName) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(test::error_of([] { BusyWait({.alpha_us = -1}); }),
            "alpha_us = -1: must be between 0 and 1e6 us");
  EXPECT_EQ(test::error_of([] { BusyWait({.beta_ns = kNaN}); }),
            "beta_ns = nan: must be between 0 and 1e6 ns");
}

}  // namespace
}  // namespace asap::busy_wait_test
