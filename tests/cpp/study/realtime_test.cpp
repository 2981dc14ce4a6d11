#include "study/realtime.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "support/streams.hpp"

namespace asap::realtime_test {
namespace {

// ---- BusyWait -------------------------------------------------------------------------------

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

// ---- scheduling_jitter ----------------------------------------------------------------------

TEST(SchedulingJitter, TheGapsAddUpToTheTimeThatPassed) {
  using namespace std::chrono_literals;
  const auto start = std::chrono::steady_clock::now();
  const LatencyHistogram gaps = scheduling_jitter(5ms);
  const auto passed = std::chrono::steady_clock::now() - start;
  const double sum_ns = gaps.mean_ns() * static_cast<double>(gaps.count());
  EXPECT_GE(sum_ns, 4.999e6);
  EXPECT_LE(sum_ns, 1.001 * static_cast<double>(std::chrono::nanoseconds(passed).count()));
  EXPECT_GT(gaps.count(), 0u);
}

}  // namespace
}  // namespace asap::realtime_test
