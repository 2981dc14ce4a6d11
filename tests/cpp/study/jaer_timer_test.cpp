#include "study/jaer_timer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::jaer_timer_test {
namespace {

using test::FakeBacklog;

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
  JaerTimer scheme(10, LinearCost({.alpha_us = 100, .beta_ns = 300}));
  for (const std::size_t count : {1u, 16'333u, 16'334u, 1'000'000u}) {
    const Decision decision = ask(scheme, count);
    EXPECT_TRUE(decision.takes);
    EXPECT_EQ(decision.stale, 0u);
    EXPECT_EQ(decision.raw, std::min<std::size_t>(count, 16'333));
    EXPECT_EQ(decision.keep, 1.0);
  }
}

TEST(JaerTimer, ThenDiscardsTheRestOfWhatWaitedAtTheStart) {
  JaerTimer scheme(10, LinearCost({.alpha_us = 100, .beta_ns = 300}));
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
  JaerTimer scheme(10, cost);
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

TEST(JaerTimer, KnowsTheDrift) {
  JaerTimer scheme(10, LinearCost({.alpha_us = 100, .beta_ns = 300, .drift = {1.0, 2.0}}));
  EXPECT_EQ(ask(scheme, 100'000, 0).raw, 16'333u);
  EXPECT_EQ(ask(scheme, 100'000, 1'000'000).raw, 8166u);
}

TEST(JaerTimer, TakesAtLeastOneEvent) {
  EXPECT_EQ(JaerTimer(10, LinearCost({.alpha_us = 6000, .beta_ns = 300}))
                .decide(FakeBacklog::of(9).at(0))
                .raw,
            1u);
  EXPECT_EQ(JaerTimer(10, LinearCost({.alpha_us = 6000, .beta_ns = 0}))
                .decide(FakeBacklog::of(9).at(0))
                .raw,
            1u);
  EXPECT_EQ(
      JaerTimer(10, LinearCost({.alpha_us = 0, .beta_ns = 0})).decide(FakeBacklog::of(9).at(0)).raw,
      9u);
}

TEST(JaerTimer, ResetForgetsTheRest) {
  JaerTimer scheme(10, LinearCost());
  ask(scheme, 20'000);
  complete(scheme, 16'333, 16'333);
  scheme.reset(Execution::whole);
  EXPECT_EQ(ask(scheme, 10).stale, 0u);
}

TEST(JaerTimer, TellsItsNameAndBound) {
  const JaerTimer scheme(7.5, LinearCost());
  EXPECT_EQ(scheme.name(), "jaer_timer");
  EXPECT_EQ(scheme.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  EXPECT_EQ(scheme.latency_bound_ns(), 7'500'000);
  EXPECT_EQ(test::error_of([] { JaerTimer bad(0, LinearCost()); }).substr(0, 16),
            "latency_ms = 0: ");
}

}  // namespace
}  // namespace asap::jaer_timer_test
