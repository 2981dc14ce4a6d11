#include "study/spark_pid.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::spark_pid_test {
namespace {

using test::FakeBacklog;

constexpr std::int64_t kPeriod = 5'000'000;  // T of L = 10 ms

// `count` events at the start of period number `period`.
FakeBacklog batch(std::int64_t period, std::size_t count) {
  return FakeBacklog(std::vector<std::int64_t>(count, period * kPeriod));
}

Decision ask(SparkPid& scheme, std::int64_t period, std::size_t count, std::int64_t now_ns,
             bool due = false) {
  return scheme.decide(batch(period, count).at(now_ns, due));
}

void complete(SparkPid& scheme, std::size_t size, std::int64_t start_ns,
              std::int64_t processing_ns) {
  scheme.observe({.size = size,
                  .raw = size,
                  .span_ns = 0,
                  .start_ns = start_ns,
                  .processing_ns = processing_ns});
}

TEST(SparkPid, ClosesAtMultiplesOfHalfTheBound) {
  SparkPid scheme(10);
  const FakeBacklog backlog({1'000'000, 4'999'999, 5'000'000, 12'000'000});
  const Decision early = scheme.decide(backlog.at(4'999'999));
  EXPECT_FALSE(early.takes);
  EXPECT_EQ(early.until_ns, kPeriod);
  for (const std::int64_t now_ns : {kPeriod, 20 * kPeriod}) {
    const Decision decision = scheme.decide(backlog.at(now_ns));
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.raw, 2u);  // the batches that have queued stay apart
    EXPECT_EQ(decision.keep, 1.0);
  }
  EXPECT_EQ(scheme.decide(FakeBacklog({-1}).at(-1)).until_ns, 0);
  EXPECT_EQ(scheme.decide(FakeBacklog({0}).at(0)).until_ns, kPeriod);
}

TEST(SparkPid, WhenDueTakesWhatThereIs) {
  SparkPid scheme(10);
  const FakeBacklog backlog({1, 2, 3});
  EXPECT_FALSE(scheme.decide(backlog.at(10)).takes);
  EXPECT_EQ(scheme.decide(backlog.at(10, true)).raw, 3u);
  complete(scheme, 3, 10, 1000);  // before its close: no wait
  EXPECT_DOUBLE_EQ(ask(scheme, 0, 60'000, kPeriod).keep, 0.003 * kPeriod / 60'000);
  ask(scheme, 1, 3, kPeriod, true);
  complete(scheme, 3, kPeriod, 1000);
  EXPECT_DOUBLE_EQ(ask(scheme, 1, 60'000, 2 * kPeriod).keep, 0.003 * kPeriod / 60'000);
}

TEST(SparkPid, ThinsToWhatTheAlgorithmAchieved) {
  SparkPid scheme(10);
  EXPECT_EQ(ask(scheme, 0, 8000, kPeriod).keep, 1.0);
  complete(scheme, 8000, kPeriod, 2'000'000);  // v = 4 per us: 20'000 per T, the first q
  EXPECT_DOUBLE_EQ(ask(scheme, 1, 40'000, 2 * kPeriod).keep, 0.5);
  EXPECT_EQ(ask(scheme, 1, 40'000, 2 * kPeriod).raw, 40'000u);
  EXPECT_EQ(ask(scheme, 1, 20'000, 2 * kPeriod).keep, 1.0);
  complete(scheme, 1000, 2 * kPeriod, 1'000'000);  // without a wait q is v: 1 per us
  EXPECT_DOUBLE_EQ(ask(scheme, 2, 40'000, 3 * kPeriod).keep, 0.125);
  complete(scheme, 12'000, 3 * kPeriod + 2'500'000, 2'000'000);
  // v = 6 per us, waited for T/2: q = 6 - 0.1 x 6.
  EXPECT_DOUBLE_EQ(ask(scheme, 3, 40'000, 4 * kPeriod).keep, 5.4 * 5000 / 40'000);
  complete(scheme, 4000, 8 * kPeriod, 1'000'000);  // waited for 4 T: q = 4 - 0.8 x 4
  EXPECT_DOUBLE_EQ(ask(scheme, 9, 40'000, 10 * kPeriod).keep, 0.8 * 5000 / 40'000);
  complete(scheme, 4000, 16 * kPeriod, 1'000'000);  // waited for 6 T: at least 0.05 v
  EXPECT_DOUBLE_EQ(ask(scheme, 18, 40'000, 19 * kPeriod).keep, 0.2 * 5000 / 40'000);
}

// A push law would have thinned a batch when it closed, however long it has queued since.
TEST(SparkPid, ABatchKnowsOnlyWhatWasKnownWhenItClosed) {
  SparkPid scheme(10);
  ask(scheme, 0, 10'000, kPeriod);
  complete(scheme, 10'000, kPeriod, 12'000'000);            // until 17 ms
  EXPECT_EQ(ask(scheme, 1, 10'000, 17'000'000).keep, 1.0);  // closed at 10 ms, nothing known
  complete(scheme, 10'000, 17'000'000, 3'000'000);          // until 20 ms
  EXPECT_EQ(ask(scheme, 2, 10'000, 20'000'000).keep, 1.0);  // closed at 15 ms
  complete(scheme, 10'000, 20'000'000, 2'000'000);          // until 22 ms
  // Closed at 20 ms, with the second package: 10 / 3 per us after a wait of 1.4 T.
  const double q = 10e3 / 3e6 * (1 - 0.2 * 1.4);
  EXPECT_DOUBLE_EQ(ask(scheme, 3, 40'000, 22'000'000).keep, q * kPeriod / 40'000);
}

TEST(SparkPid, AQueueLongerThanItsMemoryIsThinnedAllTheSame) {
  SparkPid scheme(10);
  for (std::int64_t k = 0; k < 1000; ++k) {
    const std::int64_t now_ns = 1'000'000 * kPeriod + k * 1000;
    const Decision decision = ask(scheme, k, 10'000, now_ns);
    ASSERT_TRUE(decision.takes);
    ASSERT_EQ(decision.keep < 1.0, k >= 256);
    complete(scheme, 1, now_ns, 1000);
  }
}

TEST(SparkPid, NeverStarves) {
  SparkPid scheme(10);
  complete(scheme, 1, 0, 60'000'000'000);                          // a minute per event
  EXPECT_EQ(ask(scheme, 20'000, 4, 20'001 * kPeriod).keep, 0.25);  // one event
}

TEST(SparkPid, IsNotWedgedByAbsurdOutcomes) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max() / 4;
  SparkPid scheme(10);
  for (const std::int64_t processing_ns : {std::int64_t{0}, std::int64_t{-1}, -kMost, kMost}) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{1} << 40}) {
      complete(scheme, size, 0, processing_ns);
      const Decision decision = ask(scheme, 1, 10, 2 * kPeriod);
      ASSERT_TRUE(decision.takes);
      ASSERT_EQ(decision.raw, 10u);
      ASSERT_GE(decision.keep, 0.1);
      ASSERT_LE(decision.keep, 1.0);
    }
  }
}

TEST(SparkPid, ResetBringsTheFirstStateBack) {
  SparkPid scheme(10);
  complete(scheme, 1, 0, 1'000'000);
  EXPECT_LT(ask(scheme, 1, 10'000, 2 * kPeriod).keep, 1.0);
  scheme.reset(Execution::whole);
  EXPECT_EQ(ask(scheme, 1, 10'000, 2 * kPeriod).keep, 1.0);
}

TEST(SparkPid, TellsItsNameAndBound) {
  const SparkPid scheme(7.5);
  EXPECT_EQ(scheme.name(), "spark_pid");
  EXPECT_EQ(scheme.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  EXPECT_EQ(scheme.latency_bound_ns(), 7'500'000);
  EXPECT_EQ(test::error_of([] { SparkPid bad(0); }).substr(0, 16), "latency_ms = 0: ");
}

}  // namespace
}  // namespace asap::spark_pid_test
