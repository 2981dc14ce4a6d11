#include "study/greedy_pie.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::greedy_pie_test {
namespace {

// gamma when the oldest waiting event is this old.
double gamma_at(GreedyPie& scheme, double age_ms) {
  constexpr std::int64_t kNow = 1'000'000'000;
  return scheme.gamma({.now_ns = kNow,
                       .arrived = 1000,
                       .waiting = 1000,
                       .oldest_ns = kNow - static_cast<std::int64_t>(age_ms * 1e6)});
}

TEST(GreedyPie, TakesAllThatWaitsAtOnce) {
  GreedyPie scheme(10);
  for (const bool due : {false, true}) {
    const Decision decision = scheme.decide(test::FakeBacklog::of(1234).at(99'000'000, due));
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.raw, 1234u);
    EXPECT_EQ(decision.keep, 1.0);
  }
}

// p += 20 (d - 5 ms), and 200 (d - d_old) if the two ages together exceed 0.2 ms.
TEST(GreedyPie, FollowsTheAgeOfTheOldestEvent) {
  GreedyPie scheme(10);
  const struct {
    double age_ms;
    double drop;
  } table[] = {{0, 0.0},   // -0.1
               {5, 0.99},  // 0 + 200 x 5 ms
               {4, 0.77},  // 0.99 - 0.02 - 0.2
               {7, 0.99},  // 0.77 + 0.04 + 0.6
               {6, 0.81},  // 0.99 + 0.02 - 0.2
               {6, 0.83},  // 0.81 + 0.02
               {0, 0.0}};  // 0.83 - 0.1 - 1.2
  for (const auto& row : table) EXPECT_NEAR(gamma_at(scheme, row.age_ms), 1 - row.drop, 1e-12);
}

TEST(GreedyPie, SmallAgesSteerOnlySlowly) {
  GreedyPie scheme(0.1);                              // target 50 us
  EXPECT_NEAR(gamma_at(scheme, 0.15), 0.998, 1e-12);  // 20 x 100 us; 0.15 ms together
  EXPECT_NEAR(gamma_at(scheme, 0.05), 0.998, 1e-12);  // 0.2 ms together: not more
  EXPECT_NEAR(gamma_at(scheme, 0.151), 0.998 - 0.00202 - 0.0202, 1e-12);
}

TEST(GreedyPie, IsAskedEveryMillisecond) { EXPECT_EQ(GreedyPie(10).period_ns(), 1'000'000); }

TEST(GreedyPie, RecoversFromAbsurdAges) {
  GreedyPie scheme(10);
  for (const double age_ms : {1e12, -1e12, 1e12}) {
    const double gamma = gamma_at(scheme, age_ms);
    EXPECT_GE(gamma, 0.01 - 1e-12);
    EXPECT_LE(gamma, 1.0);
  }
  for (int k = 0; k < 20; ++k) gamma_at(scheme, 0);
  EXPECT_DOUBLE_EQ(gamma_at(scheme, 0), 1.0);
}

TEST(GreedyPie, ResetBringsTheFirstStateBack) {
  GreedyPie scheme(10);
  gamma_at(scheme, 9);
  scheme.reset(Execution::whole);
  EXPECT_NEAR(gamma_at(scheme, 5.1), 0.01, 1e-9);  // the step from 0, not from 9 ms
  scheme.reset(Execution::whole);
  EXPECT_DOUBLE_EQ(gamma_at(scheme, 0), 1.0);
}

TEST(GreedyPie, TellsItsNameAndBound) {
  const GreedyPie scheme(7.5);
  EXPECT_EQ(scheme.name(), "greedy_pie");
  EXPECT_EQ(scheme.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  EXPECT_EQ(scheme.latency_bound_ns(), 7'500'000);
  EXPECT_EQ(test::error_of([] { GreedyPie bad(0); }).substr(0, 16), "latency_ms = 0: ");
}

}  // namespace
}  // namespace asap::greedy_pie_test
