#include "study/scheduling_jitter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace asap::scheduling_jitter_test {
namespace {

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

TEST(SchedulingJitter, LooksAgainAndAgain) {
  std::uint64_t most = 0;  // a gap may take all the time there is
  for (int i = 0; i < 1000 && most <= 100; ++i) {
    most = std::max(most, scheduling_jitter(std::chrono::milliseconds(5)).count());
  }
  EXPECT_GT(most, 100u);
}

}  // namespace
}  // namespace asap::scheduling_jitter_test
