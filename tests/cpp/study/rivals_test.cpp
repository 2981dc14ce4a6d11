#include "study/rivals.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <type_traits>
#include <vector>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::rivals_test {
namespace {

using namespace std::chrono_literals;

using test::FakeBacklog;

template <class S>
S made(std::chrono::nanoseconds latency) {
  if constexpr (std::is_same_v<S, JaerTimer>) {
    return S(latency, LinearCost({.alpha_us = 100, .beta_ns = 300}));
  } else {
    return S(latency);
  }
}

template <class S>
class EveryRival : public ::testing::Test {};

using Rivals = ::testing::Types<GreedyClear, JaerTimer, SparkPid>;
TYPED_TEST_SUITE(EveryRival, Rivals);

TYPED_TEST(EveryRival, HasALatencyBoundThatStays) {
  auto scheme = made<TypeParam>(7500us);
  EXPECT_EQ(scheme.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  scheme.set_latency_bound_ns(1'000'000);
  EXPECT_EQ(scheme.latency_bound_ns(), 7'500'000);
  EXPECT_EQ(test::error_of([] { made<TypeParam>(-1ms); }),
            "latency = -1 ms: must be between 0.01 and 1e7 ms");
}

TYPED_TEST(EveryRival, IsNotWedgedByAbsurdOutcomesAndForgetsThemWithAReset) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max() / 4;
  constexpr std::int64_t kNow = 10'000'000;
  auto scheme = made<TypeParam>(10ms);
  const FakeBacklog backlog({kNow - 3, kNow - 2, kNow - 1});
  const Decision first = scheme.decide(backlog.at(kNow, true));
  scheme.reset(Execution::whole);
  for (const std::int64_t processing_ns : {std::int64_t{0}, std::int64_t{-1}, -kMost, kMost}) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{1} << 40}) {
      scheme.observe(
          {.size = size, .raw = size, .span_ns = 0, .start_ns = 0, .processing_ns = processing_ns});
      const Decision decision = scheme.decide(backlog.at(kNow, true));
      ASSERT_TRUE(decision.takes);
      ASSERT_GE(decision.raw + decision.stale, 1u);
      ASSERT_GT(decision.gamma, 0.0);
      ASSERT_LE(decision.gamma, 1.0);
    }
  }
  scheme.reset(Execution::whole);
  const Decision again = scheme.decide(backlog.at(kNow, true));
  EXPECT_EQ(again.raw, first.raw);
  EXPECT_EQ(again.stale, first.stale);
  EXPECT_EQ(again.gamma, first.gamma);
}

// ---- GreedyClear ----------------------------------------------------------------------------

TEST(GreedyClear, TakesAllThatWaitsUpToHalfTheBound) {
  GreedyClear scheme(10ms);
  const FakeBacklog backlog({0, 1, 4'000'000, 5'000'000});
  for (const bool due : {false, true}) {
    const Decision decision = scheme.decide(backlog.at(5'000'000, due));
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.stale, 0u);
    EXPECT_EQ(decision.raw, 4u);
    EXPECT_EQ(decision.gamma, 1.0);
  }
}

TEST(GreedyClear, ThenDiscardsWhatIsOlderThanFourMicroseconds) {
  GreedyClear scheme(10ms);
  constexpr std::int64_t kNow = 5'000'001;
  const FakeBacklog backlog({0, 1, 4'000'000, kNow - 4001, kNow - 4000, kNow - 10, kNow});
  const Decision decision = scheme.decide(backlog.at(kNow));
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.stale, 4u);
  EXPECT_EQ(decision.raw, 0u);  // asked again about the rest
  EXPECT_EQ(scheme.decide(FakeBacklog({kNow - 4000, kNow - 10, kNow}).at(kNow)).raw, 3u);
}

// ---- JaerTimer ------------------------------------------------------------------------------

Decision ask(JaerTimer& scheme, std::size_t count, std::int64_t now_ns = 0) {
  const FakeBacklog one({0});
  Backlog backlog = one.at(now_ns);
  backlog.count = count;
  return scheme.decide(backlog);
}

void complete(JaerTimer& scheme, std::size_t raw, std::size_t size) {
  scheme.observe({.size = size, .raw = raw, .span_ns = 0, .start_ns = 0, .processing_ns = 1});
}

// 100 us + 300 ns per event, timer 5 ms: 4900 us / 300 ns = 16333.3 events.
TEST(JaerTimer, StopsWhenTheTimerHasRun) {
  JaerTimer scheme(10ms, LinearCost({.alpha_us = 100, .beta_ns = 300}));
  for (const std::size_t count : {1u, 16'333u, 16'334u, 1'000'000u}) {
    const Decision decision = ask(scheme, count);
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.stale, 0u);
    EXPECT_EQ(decision.raw, std::min<std::size_t>(count, 16'333));
    EXPECT_EQ(decision.gamma, 1.0);
  }
}

TEST(JaerTimer, ThenDiscardsTheRestOfWhatWaitedAtTheStart) {
  JaerTimer scheme(10ms, LinearCost({.alpha_us = 100, .beta_ns = 300}));
  EXPECT_EQ(ask(scheme, 20'000).raw, 16'333u);
  complete(scheme, 16'333, 16'333);
  const Decision rest = ask(scheme, 5000);  // 3667 of then, 1333 new ones
  EXPECT_TRUE(rest.takes);
  EXPECT_EQ(rest.stale, 3667u);
  EXPECT_EQ(rest.raw, 0u);
  const Decision next = ask(scheme, 1333);
  EXPECT_EQ(next.stale, 0u);
  EXPECT_EQ(next.raw, 1333u);
  complete(scheme, 1333, 1333);
  EXPECT_EQ(ask(scheme, 7).stale, 0u);
}

TEST(JaerTimer, KnowsTheDrawOfEachPackage) {
  const LinearCost cost({.alpha_us = 100, .beta_ns = 300, .noise = 0.5, .seed = 3});
  JaerTimer scheme(10ms, cost);
  for (std::uint64_t index = 0; index < 50; ++index) {
    const double factor = cost.package(index, 0).event_ns / 300;
    const double most = (5e6 / factor - 100e3) / 300;  // (L/2/X - alpha)/beta
    EXPECT_NEAR(static_cast<double>(ask(scheme, 10'000'000).raw), most, 1.0) << index;
    complete(scheme, 9'999'999, 9'999'999);
    EXPECT_EQ(ask(scheme, 1).stale, 1u);
    ask(scheme, 1);
    complete(scheme, 1, 0);  // nothing kept: no package
  }
  scheme.reset(Execution::whole);
  const double factor = cost.package(0, 0).event_ns / 300;
  EXPECT_NEAR(static_cast<double>(ask(scheme, 10'000'000).raw), (5e6 / factor - 100e3) / 300, 1.0);
}

// ---- SparkPid -------------------------------------------------------------------------------

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
  SparkPid scheme(10ms);
  const FakeBacklog backlog({1'000'000, 4'999'999, 5'000'000, 12'000'000});
  const Decision early = scheme.decide(backlog.at(4'999'999));
  EXPECT_FALSE(early.takes);
  EXPECT_EQ(early.until_ns, kPeriod);
  for (const std::int64_t now_ns : {kPeriod, 20 * kPeriod}) {
    const Decision decision = scheme.decide(backlog.at(now_ns));
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.raw, 2u);  // the batches that have queued stay apart
    EXPECT_EQ(decision.gamma, 1.0);
  }
  EXPECT_EQ(scheme.decide(FakeBacklog({-1}).at(-1)).until_ns, 0);
  EXPECT_EQ(scheme.decide(FakeBacklog({0}).at(0)).until_ns, kPeriod);
}

TEST(SparkPid, ThinsToWhatTheAlgorithmAchieved) {
  SparkPid scheme(10ms);
  EXPECT_EQ(ask(scheme, 0, 8000, kPeriod).gamma, 1.0);
  complete(scheme, 8000, kPeriod, 2'000'000);  // v = 4 per us: 20'000 per T, the first q
  EXPECT_DOUBLE_EQ(ask(scheme, 1, 40'000, 2 * kPeriod).gamma, 0.5);
  EXPECT_EQ(ask(scheme, 1, 40'000, 2 * kPeriod).raw, 40'000u);
  EXPECT_EQ(ask(scheme, 1, 20'000, 2 * kPeriod).gamma, 1.0);
  complete(scheme, 1000, 2 * kPeriod, 1'000'000);  // without a wait q is v: 1 per us
  EXPECT_DOUBLE_EQ(ask(scheme, 2, 40'000, 3 * kPeriod).gamma, 0.125);
  complete(scheme, 12'000, 3 * kPeriod + 2'500'000, 2'000'000);
  // v = 6 per us, waited for T/2: q = 6 - 0.1 x 6.
  EXPECT_DOUBLE_EQ(ask(scheme, 3, 40'000, 4 * kPeriod).gamma, 5.4 * 5000 / 40'000);
  complete(scheme, 4000, 8 * kPeriod, 1'000'000);  // waited for 4 T: q = 4 - 0.8 x 4
  EXPECT_DOUBLE_EQ(ask(scheme, 9, 40'000, 10 * kPeriod).gamma, 0.8 * 5000 / 40'000);
  complete(scheme, 4000, 16 * kPeriod, 1'000'000);  // waited for 6 T: at least 0.05 v
  EXPECT_DOUBLE_EQ(ask(scheme, 18, 40'000, 19 * kPeriod).gamma, 0.2 * 5000 / 40'000);
}

// A push law would have thinned a batch when it closed, however long it has queued since.
TEST(SparkPid, ABatchKnowsOnlyWhatWasKnownWhenItClosed) {
  SparkPid scheme(10ms);
  ask(scheme, 0, 10'000, kPeriod);
  complete(scheme, 10'000, kPeriod, 12'000'000);             // until 17 ms
  EXPECT_EQ(ask(scheme, 1, 10'000, 17'000'000).gamma, 1.0);  // closed at 10 ms, nothing known
  complete(scheme, 10'000, 17'000'000, 3'000'000);           // until 20 ms
  EXPECT_EQ(ask(scheme, 2, 10'000, 20'000'000).gamma, 1.0);  // closed at 15 ms
  complete(scheme, 10'000, 20'000'000, 2'000'000);           // until 22 ms
  // Closed at 20 ms, with the second package: 10 / 3 per us after a wait of 1.4 T.
  const double q = 10e3 / 3e6 * (1 - 0.2 * 1.4);
  EXPECT_DOUBLE_EQ(ask(scheme, 3, 40'000, 22'000'000).gamma, q * kPeriod / 40'000);
}

}  // namespace
}  // namespace asap::rivals_test
