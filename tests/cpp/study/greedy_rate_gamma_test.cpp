#include "study/greedy_rate_gamma.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::greedy_rate_gamma_test {
namespace {

// `count` refreshes of 32 us with so many arrivals each; the last gamma.
double gamma_after(GreedyRateGamma& scheme, int count, std::size_t arrived) {
  double gamma = 1;
  for (int i = 0; i < count; ++i) {
    gamma = scheme.gamma({.now_ns = 0, .arrived = arrived, .waiting = 0, .oldest_ns = 0});
  }
  return gamma;
}

TEST(GreedyRateGamma, TakesAllThatWaitsAtOnce) {
  GreedyRateGamma scheme(10);
  for (const bool due : {false, true}) {
    const Decision decision = scheme.decide(test::FakeBacklog::of(1234).at(99'000'000, due));
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.raw, 1234u);
    EXPECT_EQ(decision.keep, 1.0);
  }
}

// Before the first package 50 us + 100 ns are assumed: mu = (1 - 100 us / 10 ms) / 100 ns
// = 9.9e6/s.
TEST(GreedyRateGamma, KeepsWhatTheAlgorithmCanDo) {
  GreedyRateGamma scheme(10);
  EXPECT_DOUBLE_EQ(gamma_after(scheme, 20'000, 9 * 32), 1.0);
  EXPECT_NEAR(gamma_after(scheme, 20'000, 20 * 32), 9.9 / 20, 1e-9);
  EXPECT_DOUBLE_EQ(gamma_after(scheme, 20'000, 0), 1.0);
}

TEST(GreedyRateGamma, TheRateIsAnAverageOverFiveMilliseconds) {
  GreedyRateGamma scheme(10);
  EXPECT_EQ(scheme.period_ns(), 32'000);
  for (const double time_ms : {3.2, 6.4, 9.6}) {
    const double rate = 40 * (1 - std::exp(-time_ms / 5));
    EXPECT_NEAR(gamma_after(scheme, 100, 40 * 32), 9.9 / rate, 1e-9) << time_ms;
  }
}

TEST(GreedyRateGamma, AtLeastATwentiethOfTheEventsPerSecond) {
  GreedyRateGamma scheme(0.1);  // 2 alpha = L
  EXPECT_NEAR(gamma_after(scheme, 20'000, 20 * 32), 0.5 / 20, 1e-9);
}

TEST(GreedyRateGamma, LearnsTheCost) {
  GreedyRateGamma scheme(10);
  for (int k = 0; k < 200; ++k) {
    const std::size_t size = std::size_t{100} << (k % 7);
    scheme.observe({.size = size,
                    .raw = size,
                    .span_ns = 0,
                    .start_ns = 0,
                    .processing_ns = static_cast<std::int64_t>(200'000 + 300 * size)});
    scheme.observe({.size = 0, .raw = 9, .span_ns = 0, .start_ns = 0, .processing_ns = 0});
  }
  EXPECT_NEAR(gamma_after(scheme, 20'000, 20 * 32), 0.96 / 0.3 / 20, 1e-3);
  scheme.reset(Execution::whole);
  EXPECT_DOUBLE_EQ(gamma_after(scheme, 1, 20 * 32), 1.0);
  EXPECT_NEAR(gamma_after(scheme, 20'000, 20 * 32), 9.9 / 20, 1e-9);
}

TEST(GreedyRateGamma, IsNotWedgedByAbsurdOutcomes) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  GreedyRateGamma scheme(10);
  for (const std::int64_t processing_ns : {std::int64_t{0}, std::int64_t{-1}, kMost, -kMost}) {
    for (int k = 0; k < 20; ++k) {
      scheme.observe(
          {.size = 1, .raw = 1, .span_ns = 0, .start_ns = 0, .processing_ns = processing_ns});
      const double gamma = gamma_after(scheme, 1, 1000);
      ASSERT_GT(gamma, 0.0);
      ASSERT_LE(gamma, 1.0);
    }
  }
}

TEST(GreedyRateGamma, TellsItsNameAndBound) {
  const GreedyRateGamma scheme(7.5);
  EXPECT_EQ(scheme.name(), "greedy_rate_gamma");
  EXPECT_EQ(scheme.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  EXPECT_EQ(scheme.latency_bound_ns(), 7'500'000);
  EXPECT_EQ(test::error_of([] { GreedyRateGamma bad(0); }).substr(0, 16), "latency_ms = 0: ");
}

}  // namespace
}  // namespace asap::greedy_rate_gamma_test
