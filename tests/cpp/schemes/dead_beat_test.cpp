#include "asap/schemes/dead_beat.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "schemes/steady_backlog.hpp"
#include "support/fake_backlog.hpp"

namespace asap::dead_beat_test {
namespace {

using namespace std::chrono_literals;

using test::FakeBacklog;
using test::Law;
using test::run_steady;

constexpr std::int64_t kNow = 1'000'000'000;
constexpr std::int64_t kMs = 1'000'000;
constexpr double kAlphaNs = 100e3;
constexpr double kBetaNs = 300.0;

// A scheme that knows its algorithm: alpha = 100 us, beta = 300 ns, hardly any noise.
DeadBeat trained(DeadBeatConfig config, Execution execution = Execution::anytime,
                 std::uint64_t packages = 400) {
  DeadBeat scheme(config);
  scheme.reset(execution);
  for (std::uint64_t k = 0; k < packages; ++k) {
    const std::size_t size = std::size_t{1} << (k % 14);
    scheme.observe({.size = size,
                    .raw = size,
                    .span_ns = 0,
                    .start_ns = 0,
                    .processing_ns = std::llround(kAlphaNs + kBetaNs * static_cast<double>(size))});
  }
  return scheme;
}

// `count` events, the oldest of that age, evenly up to now.
FakeBacklog evenly(std::size_t count, std::int64_t age_ns) {
  std::vector<std::int64_t> times;
  for (std::size_t i = 0; i < count; ++i) {
    times.push_back(kNow - age_ns +
                    static_cast<std::int64_t>(i) * age_ns / static_cast<std::int64_t>(count));
  }
  return FakeBacklog(std::move(times));
}

Decision decide(DeadBeat& scheme, std::size_t count, std::int64_t age_ns) {
  const FakeBacklog events = evenly(count, age_ns);
  return scheme.decide(events.at(kNow));
}

double size_of(const Decision& decision) {
  return decision.gamma * static_cast<double>(decision.raw);
}

TEST(DeadBeat, DoubtsAFixedCostThatRulesTheBoundOut) {
  for (const Execution execution : {Execution::whole, Execution::anytime}) {
    DeadBeat doubts = trained({.latency = 390us}, execution, 403);  // 1024 events last: late
    const Decision one = decide(doubts, 100, kMs / 10);
    EXPECT_EQ(one.raw, 1u);
    EXPECT_EQ(one.gamma, 1.0);
    DeadBeat believes = trained({.latency = 405us}, execution, 403);
    EXPECT_GT(decide(believes, 100, kMs / 10).raw, 1u);
  }
}

TEST(DeadBeat, ThinsToHalfTheBound) {
  DeadBeat scheme = trained({.knee = 0});
  const Decision decision = decide(scheme, 50'000, 5 * kMs);
  EXPECT_EQ(decision.raw, 50'000u);  // all of it leaves
  EXPECT_NEAR(size_of(decision), (5e6 - 1e5) / 300, 1);
  EXPECT_EQ(decision.budget_ns, 5 * kMs);
}

TEST(DeadBeat, DropsWhatIsTooOldForHalfAPackage) {
  DeadBeat scheme = trained({.knee = 0});
  EXPECT_EQ(decide(scheme, 80'000, 7'500'000).stale, 0u);
  const Decision decision = decide(scheme, 80'000, 8 * kMs);
  EXPECT_EQ(decision.stale, 30'000u);  // older than 5 ms
  EXPECT_EQ(decision.raw, 50'000u);
  EXPECT_EQ(decision.budget_ns, 5 * kMs);
}

TEST(DeadBeat, DropsAllWhereAllIsTooOld) {
  DeadBeat scheme = trained({.knee = 0});
  const FakeBacklog events({kNow - 30 * kMs, kNow - 20 * kMs});
  const Decision decision = scheme.decide(events.at(kNow, true));
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.stale, 2u);
  EXPECT_EQ(decision.raw, 0u);
}

TEST(DeadBeat, TheKneeIsInForceFromTheNextPackageOnAndWhileThereIsMuchToDo) {
  DeadBeat scheme = trained({.knee = 33});
  const auto budget_us = [&](std::size_t count) {
    return std::lround(static_cast<double>(decide(scheme, count, kMs).budget_ns) / 1e3);
  };
  EXPECT_EQ(budget_us(1000), 5000);
  EXPECT_EQ(budget_us(20'000), 5000);
  EXPECT_EQ(budget_us(20'000), 3300);
  EXPECT_EQ(budget_us(9'000), 3300);  // 2.8 ms < 0.9 x 3.3 ms
  for (int calm = 1; calm < 3; ++calm) EXPECT_EQ(budget_us(9'000), 3300);
  EXPECT_EQ(budget_us(10'000), 3300);  // 3.1 ms: not calm
  for (int calm = 0; calm < 4; ++calm) EXPECT_EQ(budget_us(9'000), 3300);
  EXPECT_EQ(budget_us(9'000), 5000);
}

// With a knee of less than two events, one of every two that came together would be lost for ever
// (the simulation's seed 512626).
TEST(DeadBeat, OneEventAtATimeIsNoOverload) {
  DeadBeat scheme({.knee = 1});  // L / 10, and an event takes 0.95 of that
  scheme.reset(Execution::anytime);
  for (std::size_t k = 0; k < 240; ++k) {
    const std::size_t size = 1 + k % 3;
    const auto cost_ns = 100'000 + 850'000 * static_cast<std::int64_t>(size);
    scheme.observe(
        {.size = size, .raw = size, .span_ns = 0, .start_ns = 0, .processing_ns = cost_ns});
  }
  EXPECT_NEAR(size_of(decide(scheme, 10, kMs)), 4.9e6 / 850e3, 0.01);
  EXPECT_LT(size_of(decide(scheme, 2, kMs)), 1.1);
  for (int calm = 0; calm < 4; ++calm) decide(scheme, 1, kMs);
  EXPECT_EQ(size_of(decide(scheme, 2, kMs)), 2.0);
}

TEST(DeadBeat, TheKneeHasAFloorAndACap) {
  const auto budget_ms = [](DeadBeatConfig config) {
    DeadBeat scheme = trained(config);
    decide(scheme, 500'000, kMs);
    return static_cast<double>(decide(scheme, 500'000, kMs).budget_ns) / 1e6;
  };
  EXPECT_NEAR(budget_ms({.knee = 5}), 1.0, 1e-3);     // L / 10
  EXPECT_NEAR(budget_ms({.knee = 1000}), 5.0, 1e-3);  // L / 2
  EXPECT_NEAR(budget_ms({.knee = 20}), 2.0, 1e-3);
  EXPECT_NEAR(budget_ms({.knee = 20, .min_interval = 4ms}), 4.0, 1e-3);
}

TEST(DeadBeat, ALastResortIsAQuarterAlphaOfEvents) {
  DeadBeat scheme = trained({.latency = 200us, .knee = 0});
  EXPECT_NEAR(size_of(decide(scheme, 1000, 50'000)), kAlphaNs / 4 / kBetaNs, 1e-2);
}

// Of 4 ms for 10 events nobody knows what 16 will cost; L / 2 with caution is 4.2 ms.
TEST(DeadBeat, AWholePackageIsNoLargerThanIsSafe) {
  for (const Execution execution : {Execution::whole, Execution::anytime}) {
    DeadBeat scheme({.knee = 0});
    scheme.reset(execution);
    for (int k = 0; k < 3; ++k) {
      scheme.observe(
          {.size = 10, .raw = 10, .span_ns = 0, .start_ns = 0, .processing_ns = 4 * kMs});
    }
    const Decision decision = decide(scheme, 1000, kMs);
    const bool is_whole = execution == Execution::whole;
    EXPECT_EQ(size_of(decision), is_whole ? 11 : 1000) << "the clock ends it";
    EXPECT_DOUBLE_EQ(decision.max_event_ns, is_whole ? 0 : 4e5);
  }
}

TEST(DeadBeat, KeepsTheBoundAndWhatTheoryAllows) {
  const auto slow = [](std::size_t) { return Law{kAlphaNs, kBetaNs}; };
  for (const double rho : {1.5, 3.0, 10.0}) {
    DeadBeat plain({.knee = 0});
    const auto run = run_steady(plain, Execution::anytime, rho / 0.3, 2000 * kMs, slow);
    EXPECT_NEAR(run.kept, 0.98 / rho, 0.01 / rho);  // (1 - 2 alpha / L) / rho
    EXPECT_LE(run.latency_ns, 1.001 * 10e6);
    EXPECT_EQ(run.stale, 0u);

    DeadBeat knee({.knee = 20});
    const auto short_run = run_steady(knee, Execution::anytime, rho / 0.3, 2000 * kMs, slow);
    EXPECT_NEAR(short_run.kept, 0.95 / rho, 0.01 / rho);  // (1 - 1 / K) / rho
    EXPECT_LE(short_run.latency_ns, 1.001 * 10e6);

    DeadBeat whole({.knee = 0});
    const auto in_one_call = run_steady(whole, Execution::whole, rho / 0.3, 2000 * kMs, slow);
    EXPECT_GT(in_one_call.kept, 0.93 / rho);
    EXPECT_LE(in_one_call.latency_ns, 1.05 * 10e6);
  }
}

TEST(DeadBeat, LeavesAnOverloadWhereItWaitsForLongerThanTheKnee) {
  // 45 us an event every 69 us; between two starts it waits for 3.4 ms, the knee is 1.9 ms.
  for (const Execution execution : {Execution::anytime, Execution::whole}) {
    DeadBeat scheme({.latency = 13500us, .knee = 3.2, .overhead = 0.1});
    const auto cost = [](std::size_t index) {
      const double factor = index == 100 ? 8 : 1;  // an overload for once
      return Law{.alpha_ns = factor * 600e3, .beta_ns = factor * 45e3};
    };
    const auto run = run_steady(scheme, execution, 1.0 / 69, 10'000 * kMs, cost);
    EXPECT_EQ(run.kept, 1.0);
  }
}

}  // namespace
}  // namespace asap::dead_beat_test
