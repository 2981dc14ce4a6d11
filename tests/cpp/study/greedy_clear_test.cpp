#include "study/greedy_clear.hpp"

#include <gtest/gtest.h>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::greedy_clear_test {
namespace {

using test::FakeBacklog;

TEST(GreedyClear, TakesAllThatWaitsUpToHalfTheBound) {
  GreedyClear scheme(10);
  const FakeBacklog backlog({0, 1, 4'000'000, 5'000'000});
  for (const bool due : {false, true}) {
    const Decision decision = scheme.decide(backlog.at(5'000'000, due));
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.stale, 0u);
    EXPECT_EQ(decision.raw, 4u);
    EXPECT_EQ(decision.keep, 1.0);
  }
}

TEST(GreedyClear, ThenDiscardsWhatIsOlderThanFourMicroseconds) {
  GreedyClear scheme(10);
  constexpr std::int64_t kNow = 5'000'001;
  const FakeBacklog backlog({0, 1, 4'000'000, kNow - 4001, kNow - 4000, kNow - 10, kNow});
  const Decision decision = scheme.decide(backlog.at(kNow));
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.stale, 4u);
  EXPECT_EQ(decision.raw, 0u);  // asked again about the rest
  EXPECT_EQ(scheme.decide(FakeBacklog({kNow - 4000, kNow - 10, kNow}).at(kNow)).raw, 3u);
}

TEST(GreedyClear, MayDiscardAll) {
  GreedyClear scheme(10);
  EXPECT_EQ(scheme.decide(FakeBacklog({0, 1, 2}).at(6'000'000, true)).stale, 3u);
}

// Or it would throw nothing away, for ever.
TEST(GreedyClear, WhatIsLateIsNeverFresh) {
  GreedyClear scheme(0.01);  // the shortest bound there is
  EXPECT_EQ(scheme.decide(FakeBacklog({0, 1}).at(5000)).raw, 2u);
  EXPECT_EQ(scheme.decide(FakeBacklog({0, 1002}).at(5001)).stale, 1u);
}

TEST(GreedyClear, TellsItsNameAndBound) {
  const GreedyClear scheme(7.5);
  EXPECT_EQ(scheme.name(), "greedy_clear");
  EXPECT_EQ(scheme.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  EXPECT_EQ(scheme.latency_bound_ns(), 7'500'000);
  EXPECT_EQ(test::error_of([] { GreedyClear bad(-1); }).substr(0, 17), "latency_ms = -1: ");
}

}  // namespace
}  // namespace asap::greedy_clear_test
