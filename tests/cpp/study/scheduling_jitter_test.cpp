#include "asap/study/scheduling_jitter.hpp"

#include <gtest/gtest.h>

namespace asap {
namespace {

TEST(SchedulingJitter, TheGapsAddUpToTheTimeThatPassed) {
  using namespace std::chrono_literals;
  const auto start = std::chrono::steady_clock::now();
  const LatencyHistogram gaps = scheduling_jitter(5ms);
  const auto passed = std::chrono::steady_clock::now() - start;
  const double sum_ns = gaps.mean_ns() * static_cast<double>(gaps.count());
  EXPECT_GE(sum_ns, 4.999e6);
  EXPECT_LE(sum_ns, 1.001 * static_cast<double>(std::chrono::nanoseconds(passed).count()));
  EXPECT_GT(gaps.count(), 100u);
}

}  // namespace
}  // namespace asap
