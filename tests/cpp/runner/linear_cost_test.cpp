#include "asap/runner/simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/errors.hpp"

namespace asap::linear_cost_test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kEndOfTimeNs = 9'200'000'000'000'000'000;

TEST(LinearCost, TheNoiseHasMeanOne) {
  constexpr int kCount = 200'000;
  for (const double noise : {0.1, 0.5, 1.0}) {
    const LinearCost cost({.alpha_us = 1000, .beta_ns = 0, .noise = noise, .seed = 4});
    double sum = 0;
    double sum_of_logs = 0;
    double squares_of_logs = 0;
    for (std::uint64_t i = 0; i < kCount; ++i) {
      const double factor = cost.package(i, 0).of(1) / 1e6;
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

TEST(LinearCost, OneDrawScalesTheWholePackage) {
  const LinearCost cost({.alpha_us = 100, .beta_ns = 300, .noise = 0.5, .drift = {2.0}});
  for (std::uint64_t i = 0; i < 100; ++i) {
    const PackageCost package = cost.package(i, 0);
    EXPECT_DOUBLE_EQ(package.event_ns / 600, package.fixed_ns / 100'000);  // alpha does not drift
  }
}

TEST(LinearCost, DriftsInStepsOfAMillisecond) {
  const LinearCost cost({.alpha_us = 100, .beta_ns = 300, .drift = {1.0, 0.5, 3.0}});
  const auto expect = [&](std::int64_t time_ns, double event_ns) {
    EXPECT_EQ(cost.event_ns(time_ns), event_ns) << time_ns;
    EXPECT_EQ(cost.package(0, time_ns).event_ns, event_ns) << time_ns;
    EXPECT_EQ(cost.package(0, time_ns).fixed_ns, 100'000) << time_ns;
  };
  expect(-5 * kMillisecond, 300);  // the first one before its time
  expect(0, 300);
  expect(kMillisecond - 1, 300);
  expect(kMillisecond, 150);
  expect(2 * kMillisecond - 1, 150);
  expect(2 * kMillisecond, 900);
  expect(kEndOfTimeNs, 900);  // the last one stays
}

// Nanosecond by nanosecond.
TEST(LinearCost, OutagesAgreeWithACount) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(seed);
    std::vector<Outage> outages;
    std::int64_t free_ns = 0;
    for (std::uint64_t i = 0; i < 10; ++i) {
      const std::int64_t begin_ns = free_ns + static_cast<std::int64_t>(random(2 * i) % 30);
      free_ns = begin_ns + 1 + static_cast<std::int64_t>(random(2 * i + 1) % 30);
      outages.push_back({begin_ns, free_ns});
    }
    const LinearCost cost({.outages = outages});
    const auto is_out = [&](std::int64_t time_ns) {
      return std::any_of(outages.begin(), outages.end(), [&](const Outage& outage) {
        return outage.begin_ns <= time_ns && time_ns < outage.end_ns;
      });
    };
    for (std::int64_t begin_ns = 0; begin_ns < 300; begin_ns += 7) {
      std::int64_t now_ns = begin_ns;
      while (is_out(now_ns)) ++now_ns;
      ASSERT_EQ(cost.start_ns(begin_ns), now_ns);
      for (int work_ns = 1; work_ns < 200; ++work_ns) {
        while (is_out(now_ns)) ++now_ns;
        ++now_ns;
        ASSERT_EQ(cost.done_ns(begin_ns, work_ns), now_ns) << begin_ns << " + " << work_ns;
      }
    }
  }
}

TEST(LinearCost, NothingIsDoneAfterTheEndOfTime) {
  const LinearCost cost;
  EXPECT_EQ(cost.done_ns(0, 1e30), kEndOfTimeNs);
  EXPECT_EQ(cost.done_ns(kEndOfTimeNs - 1'000'000, 1e30), kEndOfTimeNs);
  const LinearCost broken({.outages = {{1000, kEndOfTimeNs - 500}}});
  EXPECT_EQ(broken.done_ns(0, 1'000'000), kEndOfTimeNs);
  EXPECT_EQ(broken.start_ns(5000), kEndOfTimeNs - 500);
}

TEST(LinearCost, RefusesOutagesThatOverlapOrEndBeforeTheyBegin) {
  const auto error = [](std::vector<Outage> outages) {
    return test::error_of([=] { LinearCost cost({.outages = outages}); });
  };
  EXPECT_EQ(error({{10, 20}, {20, 30}}), "nothing was thrown");
  EXPECT_EQ(error({{10, 20}, {19, 30}}),
            "outages = 19: give them in order, each beginning after the one before has ended, ns");
  EXPECT_EQ(error({{10, 20}, {5, 8}}),
            "outages = 5: give them in order, each beginning after the one before has ended, ns");
  EXPECT_EQ(error({{10, 10}}), "outages = 10: an outage ends after it has begun, ns");
  EXPECT_EQ(error({{10, 9}}), "outages = 9: an outage ends after it has begun, ns");
}

// Found by the fuzzer: an algorithm that started behind the end of time was done before.
TEST(LinearCost, RefusesAnOutageThatNeverEnds) {
  const auto last = static_cast<std::int64_t>(9.2e18);
  EXPECT_EQ(test::error_of([=] { LinearCost({.outages = {{0, last + 1}}}); }),
            "outages = 9200000000000000001: an outage ends within 9.2e18 ns of run time");
  const LinearCost cost({.outages = {{0, last}}});
  EXPECT_EQ(cost.start_ns(5), last);
  EXPECT_EQ(cost.done_ns(last, 100.0), last);
}

}  // namespace
}  // namespace asap::linear_cost_test
