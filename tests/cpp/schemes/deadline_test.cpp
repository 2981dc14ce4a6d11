#include "asap/schemes/deadline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "asap/core/random.hpp"
#include "schemes/steady_backlog.hpp"
#include "support/errors.hpp"
#include "support/fake_backlog.hpp"
#include "support/outcomes.hpp"

namespace asap::deadline_test {
namespace {

// ---- OutageReserve --------------------------------------------------------------------------

constexpr double kBound = 1000.0;
constexpr double kSpan = 400.0;
constexpr double kAlpha = 10.0;

TEST(OutageReserve, GrowsWithTheShareOfLateEvents) {
  OutageReserve reserve;
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 0.0);
  reserve.observe(1100, kSpan, kBound);  // a quarter of the span is late
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * (0.25 - 0.005) * kBound, 1e-9);
  EXPECT_NEAR(reserve.ns(2 * kBound, kAlpha), 0.1 * (0.25 - 0.005) * kBound, 1e-9);
  reserve.observe(5000, kSpan, kBound);  // all of it
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * (1.25 - 0.01) * kBound, 1e-9);
  reserve.observe(1011, 0, kBound);  // one event
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * (2.25 - 0.015) * kBound, 1e-9);
}

TEST(OutageReserve, ShrinksWhileNothingIsLate) {
  OutageReserve reserve;
  for (int k = 0; k < 4; ++k) reserve.observe(5000, kSpan, kBound);
  const double before = reserve.ns(kBound, kAlpha);
  for (int k = 0; k < 100; ++k) reserve.observe(1000, kSpan, kBound);
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), before - 100 * 0.05 * 0.005 * kBound, 1e-9);
  for (int k = 0; k < 1000; ++k) reserve.observe(10, kSpan, kBound);
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 0.0);
  reserve.observe(1400, kSpan, kBound);  // there is no debt
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * 0.995 * kBound, 1e-9);
}

TEST(OutageReserve, AHundredthOfTheBoundIsNoOutage) {
  OutageReserve reserve;
  for (int k = 0; k < 100; ++k) reserve.observe(1010, 10, kBound);
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 0.0);
}

TEST(OutageReserve, IsHalfTheBoundAtMost) {
  OutageReserve reserve;
  for (int k = 0; k < 1000; ++k) reserve.observe(1e18, kSpan, kBound);
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 500);
  EXPECT_EQ(reserve.ns(kBound, 200), 200);  // four fixed costs have to fit
  EXPECT_EQ(reserve.ns(kBound, 250), 0);
  EXPECT_EQ(reserve.ns(kBound, 1e6), 0);
}

// One late package in a thousand leaves no reserve behind, one in ten does.
TEST(OutageReserve, RareOutagesCostNothing) {
  OutageReserve rare;
  OutageReserve frequent;
  for (int k = 0; k < 5000; ++k) {
    rare.observe(k % 1000 == 0 ? 5000 : 900, kSpan, kBound);
    frequent.observe(k % 10 == 0 ? 5000 : 900, kSpan, kBound);
  }
  EXPECT_EQ(rare.ns(kBound, kAlpha), 0.0);
  EXPECT_GT(frequent.ns(kBound, kAlpha), 490);
}

// ---- Deadline -------------------------------------------------------------------------------

using test::error_of;
using test::FakeBacklog;
using test::Law;
using test::run_steady;

constexpr std::int64_t kNow = 1'000'000'000;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kUs = 1'000;
constexpr double kAlphaNs = 100e3;
constexpr double kBetaNs = 300.0;

void observe(Deadline& scheme, std::size_t size, std::size_t raw, double processing_ns) {
  scheme.observe({.size = size,
                  .raw = raw,
                  .span_ns = 0,
                  .start_ns = 0,
                  .processing_ns = std::llround(processing_ns)});
}

void train(Deadline& scheme, std::uint64_t packages, double alpha_ns) {
  for (std::uint64_t k = 0; k < packages; ++k) {
    const std::size_t size = std::size_t{1} << (k % 14);
    observe(scheme, size, size, alpha_ns + kBetaNs * static_cast<double>(size));
  }
}

// A scheme that knows its algorithm: alpha = 100 us, beta = 300 ns, hardly any noise. L is 10 ms,
// T_hi = 5 ms, T_lo = sqrt(12 alpha L) = 3.4641 ms.
Deadline trained(DeadlineConfig config = {}, Execution execution = Execution::anytime,
                 std::uint64_t packages = 400, double alpha_ns = kAlphaNs) {
  Deadline scheme(config);
  scheme.reset(execution);
  train(scheme, packages, alpha_ns);
  return scheme;
}

struct Stretch {
  std::size_t count;
  std::int64_t from_ns, to_ns;  // ages, the older first
};

// Events spread evenly over stretches of age, the older stretch first.
FakeBacklog spread(const std::vector<Stretch>& stretches) {
  std::vector<std::int64_t> times;
  for (const Stretch& stretch : stretches) {
    const double step =
        static_cast<double>(stretch.from_ns - stretch.to_ns) / static_cast<double>(stretch.count);
    for (std::size_t i = 0; i < stretch.count; ++i) {
      times.push_back(kNow - stretch.from_ns +
                      static_cast<std::int64_t>(step * static_cast<double>(i)));
    }
  }
  return FakeBacklog(std::move(times));
}

FakeBacklog evenly(std::size_t count, std::int64_t age_ns) { return spread({{count, age_ns, 0}}); }

Decision decide(Deadline& scheme, const FakeBacklog& events, std::int64_t interval_ns = 5 * kMs) {
  Backlog backlog = events.at(kNow);
  backlog.previous_start_ns = kNow - interval_ns;
  return scheme.decide(backlog);
}

double size_of(const Decision& decision) {
  return decision.keep * static_cast<double>(decision.raw);
}

double budget_ms(const Decision& decision) { return static_cast<double>(decision.budget_ns) / 1e6; }

// ---- hold, stale, fit -------------------------------------------------------------------------

TEST(Deadline, HoldsForTheOverheadUnlessDue) {
  Deadline scheme = trained({.overhead = 0.25});
  const FakeBacklog events = evenly(10, 50 * kUs);
  Backlog backlog = events.at(kNow);
  EXPECT_TRUE(scheme.decide(backlog).takes);  // the first package
  backlog.previous_start_ns = kNow - 100 * kUs;
  const Decision waits = scheme.decide(backlog);
  EXPECT_FALSE(waits.takes);
  EXPECT_NEAR(static_cast<double>(waits.until_ns - kNow), 300e3, 1);
  backlog.due = true;
  EXPECT_TRUE(scheme.decide(backlog).takes);
}

TEST(Deadline, DoubtsAFixedCostThatRulesTheBoundOut) {
  for (const Execution execution : {Execution::whole, Execution::anytime}) {
    Deadline doubts = trained({.latency_ms = 0.39}, execution, 399);
    const Decision one = decide(doubts, evenly(100, 100 * kUs));
    EXPECT_EQ(one.raw, 1u);
    EXPECT_EQ(one.keep, 1.0);
    Deadline later = trained({.latency_ms = 0.39}, execution, 400);
    EXPECT_GT(decide(later, evenly(100, 100 * kUs)).raw, 1u);
    Deadline believes = trained({.latency_ms = 0.41}, execution, 399);
    EXPECT_GT(decide(believes, evenly(100, 100 * kUs)).raw, 1u);
  }
}

TEST(Deadline, DropsWhatHasNoChanceAndIsAskedAgain) {
  Deadline scheme = trained();
  // 1.5 alpha before the bound nothing is lost yet.
  EXPECT_EQ(decide(scheme, FakeBacklog({kNow - 9849 * kUs})).stale, 0u);
  // Beyond, all that is older than L - T_lo = 6.5359 ms goes.
  const FakeBacklog events({kNow - 9851 * kUs, kNow - 7000 * kUs, kNow - 6537 * kUs,
                            kNow - 6535 * kUs, kNow - 1000 * kUs});
  const Decision decision = decide(scheme, events);
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.stale, 3u);
  EXPECT_EQ(decision.raw, 0u);
  const Decision rest = decide(scheme, FakeBacklog({kNow - 6535 * kUs, kNow - 1000 * kUs}));
  EXPECT_EQ(rest.stale, 0u);
  EXPECT_EQ(rest.raw, 2u);
}

// T_lo = 1 ms is less than 1.5 alpha here.
TEST(Deadline, WhatIsDroppedLeavesTimeForAPackage) {
  Deadline scheme = trained({.knee = 1}, Execution::anytime, 400, 1e6);
  EXPECT_EQ(decide(scheme, FakeBacklog({kNow - 8700 * kUs, kNow - 8400 * kUs}), 50 * kMs).stale,
            1u);
  EXPECT_EQ(decide(scheme, FakeBacklog({kNow - 8400 * kUs}), 50 * kMs).raw, 1u);
}

TEST(Deadline, TakesAllThatFits) {
  Deadline scheme = trained();
  const Decision decision = decide(scheme, evenly(10'000, 3 * kMs));
  EXPECT_EQ(decision.raw, 10'000u);
  EXPECT_EQ(decision.keep, 1.0);
  EXPECT_NEAR(budget_ms(decision), 5.0, 1e-6);  // T_hi
  EXPECT_NEAR(decision.fixed_ns, kAlphaNs, 1e-3);
  EXPECT_NEAR(decision.event_ns, kBetaNs, 1e-3);
  // Until the oldest is L old.
  EXPECT_NEAR(budget_ms(decide(scheme, evenly(5000, 7 * kMs))), 3.0, 1e-6);
}

TEST(Deadline, ItsLimitsAreThoseOfTheConfiguration) {
  const auto longest_ms = [](DeadlineConfig config, Execution execution = Execution::anytime) {
    Deadline scheme = trained(config, execution);
    return budget_ms(decide(scheme, evenly(10, kMs), 50 * kMs));
  };
  EXPECT_NEAR(longest_ms({.knee = 33}), 3.3, 1e-4);
  EXPECT_NEAR(longest_ms({.knee = 5}), 1.0, 1e-4);     // L / 10
  EXPECT_NEAR(longest_ms({.knee = 1000}), 5.0, 1e-4);  // L / 2
  EXPECT_NEAR(longest_ms({.min_interval_ms = 4, .knee = 33}), 4.0, 1e-4);
  EXPECT_NEAR(longest_ms({.min_interval_ms = 40, .knee = 33}), 5.0, 1e-4);
  EXPECT_NEAR(longest_ms({.latency_ms = 40}), 20.0, 1e-4);
}

// ---- length -----------------------------------------------------------------------------------

// T = 0.9 L (load - 1) / (2 load - 1) while the reservoir is to be full.
TEST(Deadline, LengthFollowsTheLoad) {
  const struct {
    double load;
    double length_ms;
  } table[] = {{1.9, 3.4641}, {2.0, 3.4641}, {3, 3.6}, {5, 4.0}, {9, 4.235294}, {100, 4.477387}};
  for (const auto& row : table) {
    Deadline scheme = trained();
    const auto count = static_cast<std::size_t>(row.load * 5e6 / kBetaNs);
    const Decision decision = decide(scheme, evenly(count, 5 * kMs));
    EXPECT_NEAR(budget_ms(decision), row.length_ms, 1e-3) << row.load;
  }
}

TEST(Deadline, LengthEndsWhenTheOldestIsTooOld) {
  Deadline scheme = trained();
  EXPECT_NEAR(budget_ms(decide(scheme, evenly(90'000, 9 * kMs))), 1.0, 1e-3);
}

// After the rush (nothing in the last L / 20) the package may use all the time there is.
TEST(Deadline, WhenTheRushIsOverThePackageIsLong) {
  Deadline scheme = trained();
  const Decision decision = decide(scheme, spread({{50'000, 4 * kMs, 1250 * kUs}}));
  EXPECT_NEAR(budget_ms(decision), 6.0, 1e-6);
  // T_n = 3 alpha: x <= 10 - 0.3 - 6 ms; the work of the reserve and the 1.25 ms (eight slots of
  // L / 64) before it begins fit into L - H - 2 alpha = 3.8 ms: 2.55 ms / beta = 8500 events.
  EXPECT_NEAR(static_cast<double>(decision.raw), 50'000 - 8500, 2);
  EXPECT_NEAR(size_of(decision), 5.9e6 / 300, 2);
}

TEST(Deadline, AShortBacklogAfterTheRushIsTakenWhole) {
  Deadline scheme = trained();
  // 5.5 ms of work, all older than L / 20, and 6 ms of room: no need to discard anything.
  const Decision decision = decide(scheme, spread({{18'000, 4 * kMs, kMs}}));
  EXPECT_EQ(decision.raw, 18'000u);
  EXPECT_EQ(decision.keep, 1.0);
  EXPECT_NEAR(budget_ms(decision), 6.0, 1e-6);
}

// Load of the last L / 20 between the two cases: 0.5 and 0.97 of it.
TEST(Deadline, TheNextLengthFollowsTheLoadOfTheLastMoment) {
  const auto decision = [](double load_now) {
    const auto recent = static_cast<std::size_t>(load_now * 500e3 / kBetaNs);
    Deadline scheme = trained();
    return decide(scheme, spread({{60'000, 4 * kMs, 500 * kUs}, {recent, 500 * kUs, 0}}));
  };
  EXPECT_NEAR(budget_ms(decision(0.5)), 6.0, 1e-3);  // all the room
  // 1 - 2 alpha / T = 0.95: the rush may go on, T = 0.9 L (4.62 - 1) / (2 x 4.62 - 1) = 3.954 ms.
  EXPECT_NEAR(budget_ms(decision(0.97)), 3.954, 5e-3);
}

// ---- reserve ----------------------------------------------------------------------------------

// Load 3: T = H = 3.6 ms. In the reserve every ms of age is 3 ms of work, and it may take
// L - H - 2 alpha = 6.2 ms: x = 2.0667 ms, less than L - T - H = 2.8 ms. So 20667 stay behind.
TEST(Deadline, TheReserveIsWhatCanStillBeFinished) {
  Deadline scheme = trained();
  const Decision decision = decide(scheme, evenly(50'000, 5 * kMs));
  EXPECT_NEAR(static_cast<double>(decision.raw), 50'000 - 20'667, 3);
  EXPECT_NEAR(size_of(decision), 3.5e6 / 300, 2);
}

// An old crowd and a thin present: then age limits the reserve, x = L - T - H = 2.8 ms and more.
TEST(Deadline, TheReserveIsNotOlderThanTheNextPackagesAllow) {
  Deadline scheme = trained();
  // Load 1.05 over the last 3.5 ms = 3500 per ms, the crowd before. 50000 events in all: load 3.
  const Decision decision =
      decide(scheme, spread({{37'750, 5 * kMs, 3500 * kUs}, {12'250, 3500 * kUs, 0}}));
  EXPECT_NEAR(budget_ms(decision), 3.6, 1e-3);
  EXPECT_NEAR(static_cast<double>(decision.raw), 50'000 - 2.8 * 3500, 3);
}

// After the rush the next package takes T_n = 3 alpha, here: x <= L - T_n - H = 3.7 ms.
TEST(Deadline, TheReserveLeavesTimeForAShortPackage) {
  Deadline scheme = trained();
  const Decision decision =
      decide(scheme, spread({{30'000, 4 * kMs, 3900 * kUs}, {3400, 3900 * kUs, 500 * kUs}}));
  EXPECT_NEAR(budget_ms(decision), 6.0, 1e-3);
  EXPECT_NEAR(static_cast<double>(decision.raw), 30'000 + 200, 2);
}

TEST(Deadline, TheReserveIsCutInsideAnAgeSlot) {
  Deadline scheme = trained();
  // The same, but a crowd of one moment in the slot from 14 to 15 x L / 64 (2.1875 .. 2.3438 ms).
  const Decision decision =
      decide(scheme, spread({{30'000, 5 * kMs, 2300 * kUs}, {20'000, 2299 * kUs, 2298 * kUs}}));
  const double left = 50'000.0 - static_cast<double>(decision.raw);
  EXPECT_GT(left, 0);
  EXPECT_LT(left, 20'000);
  // What stays behind can be done in time.
  EXPECT_LE(left * kBetaNs + 2.1875e6, 10e6 - static_cast<double>(decision.budget_ns) - 0.2e6 + 1);
}

// Load 12: H = 0.9 L x 11 / 23 = 4.3043 ms is worth 14014 events. The reserve could be 18318 of the
// 20000.
TEST(Deadline, AFullPackageComesBeforeTheReserve) {
  Deadline scheme = trained();
  const Decision decision = decide(scheme, evenly(20'000, 500 * kUs));
  EXPECT_NEAR(static_cast<double>(decision.raw), 14'014, 2);
  EXPECT_EQ(decision.keep, 1.0);
}

TEST(Deadline, ALastResortIsAQuarterAlphaOfEvents) {
  Deadline scheme = trained({.latency_ms = 0.2}, Execution::anytime, 10);  // early: L as it is
  const Decision decision = decide(scheme, evenly(1000, 50 * kUs));
  EXPECT_NEAR(size_of(decision), kAlphaNs / 4 / kBetaNs, 1);
}

// ---- the first packages, noise, impossible bounds ----------------------------------------------

TEST(Deadline, UsesAllTheTimeThereIsOnceItKnowsTheAlgorithm) {
  const FakeBacklog after_the_rush = spread({{900'000, 4 * kMs, kMs}});  // room for 6 ms
  for (const std::uint64_t k : {0u, 3u}) {
    Deadline scheme = trained({}, Execution::anytime, k);
    EXPECT_LE(budget_ms(decide(scheme, after_the_rush)), 5.0) << k;
  }
  Deadline sure = trained({}, Execution::anytime, 4);
  EXPECT_GT(budget_ms(decide(sure, after_the_rush)), 5.8);
}

TEST(Deadline, KeepsAMarginForNoise) {
  Deadline scheme;
  scheme.reset(Execution::anytime);
  CostModel model;
  const CounterRandom random(1);
  double least = 1;
  for (std::uint64_t k = 0; k < 300; ++k) {
    const double margin = 0.05 * std::max(0.0, model.sigma() - 0.05);
    const double latency_ms = 10 * (1 - margin);
    ASSERT_NEAR(budget_ms(decide(scheme, evenly(1, kMs), 50 * kMs)), latency_ms / 2, 1e-5) << k;
    least = std::min(least, 1 - margin);
    const double noise = k < 150 ? 4 * random.uniform(k) : 1.0;
    const double cost_ns = std::floor((kAlphaNs + kBetaNs * 1000) * noise);
    observe(scheme, 1000, 1000, cost_ns);
    model.update(test::package(1000, cost_ns));
  }
  EXPECT_NEAR(least, 0.9825, 1e-4);  // the noise was felt, and sigma has a limit
  EXPECT_LT(model.sigma(), 0.05);    // and is forgotten
  EXPECT_NEAR(budget_ms(decide(scheme, evenly(1, kMs), 50 * kMs)), 5.0, 1e-6);
}

TEST(Deadline, KeepsAReserveForOutages) {
  const FakeBacklog events = evenly(50'000, 5 * kMs);
  // Packages of 5 ms, taken when their oldest event was 5 ms old, and then an outage.
  const auto budget_after = [&](std::int64_t outage_ns) {
    Deadline scheme = trained();
    decide(scheme, events);
    for (int k = 0; k < 8; ++k) {
      scheme.observe({.size = 16'384,
                      .raw = 16'384,
                      .span_ns = 4 * kMs,
                      .start_ns = 0,
                      .processing_ns = std::llround(kAlphaNs + kBetaNs * 16'384) + outage_ns,
                      .outage_ns = outage_ns});
    }
    return budget_ms(decide(scheme, events));
  };
  EXPECT_NEAR(budget_after(0), 3.6, 2e-3);
  // Half a package is late, eight times: a fifth of the bound is kept free, and 5 ms are over.
  EXPECT_NEAR(budget_after(2 * kMs), 8.0 - 5.0, 0.01);
}

// Late because of its fixed cost of 5 ms, or of what nobody knew at the start. The simulation's
// seed 203469 had half of its bound kept free for thousands of packages after such a cost had
// fallen.
TEST(Deadline, DoesNotTakeACostThatBreaksTheBoundForOutages) {
  const auto budget_after = [](Deadline scheme, std::int64_t late_ns) {
    decide(scheme, evenly(10, 8 * kMs));
    for (int k = 0; k < 8; ++k) {
      scheme.observe(
          {.size = 16, .raw = 16, .span_ns = kMs, .start_ns = 0, .processing_ns = late_ns});
    }
    decide(scheme, evenly(1, kMs), 50 * kMs);
    train(scheme, 400, kAlphaNs);
    return budget_ms(decide(scheme, evenly(1, kMs), 50 * kMs));
  };
  EXPECT_NEAR(budget_after(trained({}, Execution::anytime, 400, 5e6), 5 * kMs + 5 * kUs), 5.0,
              1e-3);
  EXPECT_NEAR(budget_after(trained({}, Execution::anytime, 0), 50 * kMs), 5.0, 1e-3);
}

TEST(Deadline, DoesNotTakeOutagesForAFixedCost) {
  Deadline scheme = trained();
  for (int k = 0; k < 400; ++k) {
    const std::size_t size = 1000 + static_cast<std::size_t>(k) * 37 % 12'000;
    const auto work_ns = std::llround(kAlphaNs + kBetaNs * static_cast<double>(size));
    scheme.observe({.size = size,
                    .raw = size,
                    .span_ns = 0,
                    .start_ns = 0,
                    .processing_ns = work_ns + 4 * kMs,
                    .outage_ns = 4 * kMs});
  }
  EXPECT_NEAR(scheme.alpha_ns(), kAlphaNs, 0.01 * kAlphaNs);
  EXPECT_NEAR(scheme.beta_ns(), kBetaNs, 0.01 * kBetaNs);
}

TEST(Deadline, APackageOfSeveralPartsTellsItsFixedCost) {
  Deadline scheme;
  scheme.reset(Execution::anytime);
  const FakeBacklog events = evenly(10, kMs);
  EXPECT_EQ(decide(scheme, events).most_event_ns, std::numeric_limits<double>::infinity());
  for (int k = 0; k < 30; ++k) scheme.observe(test::in_parts(1600, 100, kAlphaNs, kBetaNs));
  EXPECT_NEAR(scheme.alpha_ns(), kAlphaNs, 0.001 * kAlphaNs);
  EXPECT_NEAR(scheme.beta_ns(), kBetaNs, 0.001 * kBetaNs);
  EXPECT_EQ(decide(scheme, events, 50 * kMs).most_event_ns, scheme.beta_ns());
}

TEST(Deadline, ABoundThatCannotBeKeptIsReplacedByTwoAndAHalfFixedCosts) {
  Deadline scheme = trained({.latency_ms = 10}, Execution::anytime, 400, 5e6);
  EXPECT_EQ(scheme.latency_bound_ns(), 10 * kMs);
  EXPECT_NEAR(budget_ms(decide(scheme, evenly(1, kMs), 50 * kMs)), 6.25, 1e-3);  // L' / 2
  Deadline dear = trained({.latency_ms = 10}, Execution::anytime, 400, 3.9e6);
  EXPECT_NEAR(budget_ms(decide(dear, evenly(1, kMs), 50 * kMs)), 5.0, 1e-3);  // it can be kept
  // On the strength of a first guess nothing is given up.
  Deadline fresh({.first_alpha_us = 5000});
  fresh.reset(Execution::anytime);
  EXPECT_NEAR(budget_ms(decide(fresh, evenly(1, kMs), 50 * kMs)), 9.925 / 2, 1e-6);
}

// ---- an algorithm that takes a package in one call --------------------------------------------

// A slice: nothing is discarded for what may be an error of the model.
TEST(Deadline, AWholePackageIsNoLargerThanIsSafe) {
  Deadline scheme;
  scheme.reset(Execution::whole);
  const FakeBacklog crowd = evenly(50'000, 4 * kMs);
  EXPECT_EQ(decide(scheme, crowd).raw, 2u);
  observe(scheme, 2, 2, 100'600);
  const Decision decision = decide(scheme, crowd);
  const double room_ns = 9.925e6 - 4e6;  // planned short for sigma = 0.2, and zeta = 1.5
  EXPECT_EQ(decision.raw, 1 + static_cast<std::size_t>(room_ns / 1.5 / 50'300));
  EXPECT_EQ(decision.keep, 1.0);
  observe(scheme, decision.raw, decision.raw, 100e3 + 300 * static_cast<double>(decision.raw));
  EXPECT_GT(decide(scheme, crowd).raw, 2000u);
}

// A second of single events and pairs, 5 % of noise, tells nothing about thousands. The line
// through these sizes has any slope; packages of up to 1.7 L came of it.
TEST(Deadline, AfterAQuietTimeAWholePackageOfARushIsInTime) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const CounterRandom random(seed);
    Deadline scheme;
    scheme.reset(Execution::whole);
    for (std::uint64_t k = 0; k < 200; ++k) {
      const std::size_t size = 1 + random(2 * k) % 2;
      const double noise = 1 + 0.1 * (2 * random.uniform(2 * k + 1) - 1);
      observe(scheme, size, size, noise * (kAlphaNs + kBetaNs * static_cast<double>(size)));
    }
    for (int k = 0; k < 5; ++k) {
      const Decision decision = decide(scheme, evenly(200'000, 3 * kMs));
      const double cost_ns = kAlphaNs + kBetaNs * size_of(decision);
      EXPECT_LE(cost_ns, 7e6) << seed << ", " << k;
      observe(scheme, static_cast<std::size_t>(size_of(decision)), decision.raw, cost_ns);
    }
    EXPECT_GT(size_of(decide(scheme, evenly(200'000, 3 * kMs))), 8000) << seed;
  }
}

// zeta = 1 + 2.5 sigma = 1.025, T_hi = L / 3.
TEST(Deadline, AWholePackageIsShorterAndPlannedWithCaution) {
  Deadline scheme = trained({}, Execution::whole);
  const Decision fits = decide(scheme, evenly(10'500, 3 * kMs));  // 1.025 x 3.25 = 3.331 ms
  EXPECT_EQ(fits.raw, 10'500u);
  EXPECT_EQ(fits.keep, 1.0);
  EXPECT_EQ(fits.budget_ns, kNever);
  EXPECT_EQ(fits.fixed_ns, 0.0);
  EXPECT_EQ(fits.event_ns, 0.0);
  const Decision decision = decide(scheme, evenly(50'000, 5 * kMs));
  EXPECT_NEAR(size_of(decision), (10e6 / 3 / 1.025 - 1e5) / 300, 2);
  // The rush is over: no long package all the same.
  const Decision after = decide(scheme, spread({{50'000, 4 * kMs, kMs}}));
  EXPECT_NEAR(size_of(after), (10e6 / 3 / 1.025 - 1e5) / 300, 2);
}

// T_hi = 4 zeta alpha, between L / 3 and L / 2.
TEST(Deadline, AWholePackageOfLargeFixedCostsIsLonger) {
  const auto size = [](double alpha_ns) {
    Deadline scheme = trained({}, Execution::whole, 400, alpha_ns);
    return size_of(decide(scheme, evenly(50'000, 4 * kMs)));
  };
  EXPECT_NEAR(size(0.8e6), (10e6 / 3 / 1.025 - 0.8e6) / 300, 2);
  EXPECT_NEAR(size(1e6), (4 * 1e6 - 1e6) / 300, 2);
  EXPECT_NEAR(size(2e6), (10e6 / 2 / 1.025 - 2e6) / 300, 2);
}

// R = L - H - 2 alpha = 10 - 3.333 - 0.2 = 6.467 ms; 3 ms of work per ms of age: x = 2.156 ms. The
// caution is the next packages' own.
TEST(Deadline, AWholePackageLeavesItsReserve) {
  Deadline scheme = trained({}, Execution::whole);
  const Decision decision = decide(scheme, evenly(50'000, 5 * kMs));
  EXPECT_NEAR(static_cast<double>(decision.raw), 50'000 - 21'556, 3);
}

// Load 0.9 after the crowd, with caution 0.9225: T_n = 2 alpha / 0.0775 = 2.5806 ms, and the
// reserve reaches back to L - T_n - L / 3 = 4.0860 ms.
TEST(Deadline, AfterWholePackagesTheLoadIsSeenWithCaution) {
  Deadline scheme = trained({}, Execution::whole);
  const Decision decision =
      decide(scheme, spread({{40'000, 5 * kMs, 4900 * kUs}, {14'700, 4900 * kUs, 0}}));
  EXPECT_NEAR(static_cast<double>(decision.raw), 54'700 - 12'258, 5);
}

// ---- the closed loop --------------------------------------------------------------------------

Law slow(std::size_t) { return {kAlphaNs, kBetaNs}; }

TEST(Deadline, KeepsTheBoundAndWhatTheoryAllows) {
  for (const double rho : {1.5, 3.0, 10.0}) {
    Deadline scheme;
    const auto run = run_steady(scheme, Execution::anytime, rho / 0.3, 2000 * kMs, slow);
    EXPECT_NEAR(run.kept, 0.98 / rho, 0.01 / rho);  // (1 - 2 alpha / L) / rho
    EXPECT_LE(run.latency_ns, 1.001 * 10e6);
    EXPECT_EQ(run.stale, 0u);

    const auto whole = run_steady(scheme, Execution::whole, rho / 0.3, 2000 * kMs, slow);
    EXPECT_GT(whole.kept, 0.93 / rho);
    EXPECT_LE(whole.latency_ns, 1.01 * 10e6);
  }
}

TEST(Deadline, BelowOverloadEverythingIsKept) {
  for (const double rho : {0.001, 0.1, 0.5, 0.9}) {
    for (const Execution execution : {Execution::anytime, Execution::whole}) {
      Deadline scheme({.overhead = 0});
      const auto run = run_steady(scheme, execution, rho / 0.3, 500 * kMs, slow);
      EXPECT_EQ(run.kept, 1.0) << rho;
      EXPECT_EQ(run.stale, 0u);
      EXPECT_LT(run.latency_ns, 5e6);
    }
  }
}

// As much as the fixed costs leave of two packages per bound, down to 2.5 of them.
TEST(Deadline, KeepsTheBoundHoweverLargeTheFixedCost) {
  for (const double alpha_ms : {1.0, 2.0, 2.6, 3.0, 3.9}) {
    for (const Execution execution : {Execution::anytime, Execution::whole}) {
      Deadline scheme;
      const Law law{alpha_ms * 1e6, 1000};
      const auto run =
          run_steady(scheme, execution, 2, 4000 * kMs, [&](std::size_t) { return law; });
      EXPECT_GT(run.kept, 0.75 * (1 - 2 * alpha_ms / 10) / 2) << alpha_ms;
      EXPECT_LE(run.latency_ns, 1.001 * 10e6) << alpha_ms;
    }
  }
}

// A callback that publishes, draws or writes now and then: 3 ms at every fourth package.
TEST(Deadline, AFixedCostNowAndThenDoesNotShrinkThePackages) {
  Deadline scheme;
  const auto run = run_steady(scheme, Execution::whole, 1, 40'000 * kMs, [](std::size_t k) {
    return Law{20e3 + (k % 4 == 3 ? 3e6 : 0), 300};
  });
  EXPECT_GT(run.kept, 0.95);
  EXPECT_LE(run.latency_ns, 10e6);
}

// The mean package of a quiet scene: alpha / overhead apart.
TEST(Deadline, TheOverheadIsKept) {
  Deadline scheme({.overhead = 0.25});
  const auto run = run_steady(scheme, Execution::anytime, 0.1, 1000 * kMs, slow);
  EXPECT_NEAR(static_cast<double>(run.packages), 2500, 100);  // 0.25 s of alpha
}

TEST(Deadline, WrongFirstGuessesAreHarmless) {
  for (const double alpha_error : {1e-4, 0.01, 1.0, 100.0, 1e4}) {
    for (const double beta_error : {1e-4, 0.01, 1.0, 100.0, 1e4}) {
      Deadline scheme({.first_alpha_us = 100 * alpha_error, .first_beta_ns = 300 * beta_error});
      const auto run = run_steady(scheme, Execution::anytime, 10, 1000 * kMs, slow);
      EXPECT_NEAR(run.kept, 0.98 / 3, 0.004) << alpha_error << ", " << beta_error;
      EXPECT_LE(run.latency_ns, 1.001 * 10e6) << alpha_error << ", " << beta_error;
      EXPECT_NEAR(scheme.beta_ns(), kBetaNs, 1);
    }
  }
}

// F6, F7: a cost that jumps by 100, both ways, and packages that stall.
TEST(Deadline, SurvivesCostsThatJump) {
  for (const Execution execution : {Execution::anytime, Execution::whole}) {
    Deadline scheme;
    const auto jumping = run_steady(scheme, execution, 1, 4000 * kMs, [](std::size_t k) {
      const double factor = k / 300 % 2 == 0 ? 0.1 : 10.0;
      return Law{kAlphaNs * factor, kBetaNs * factor};
    });
    EXPECT_GT(jumping.packages, 900u);
    EXPECT_GT(jumping.kept, 0.1);
    const auto stalling = run_steady(scheme, execution, 1, 4000 * kMs, [](std::size_t k) {
      return Law{k % 100 == 50 ? 200e6 : kAlphaNs, kBetaNs};
    });
    EXPECT_GT(stalling.packages, 900u);
    EXPECT_NEAR(scheme.beta_ns(), kBetaNs, 0.3 * kBetaNs);
  }
}

TEST(Deadline, LearnsACostThatHasJumpedByAHundred) {
  Deadline scheme;
  run_steady(scheme, Execution::whole, 1, 20'000 * kMs, [](std::size_t k) {
    const double factor = k < 500 ? 0.1 : 10.0;
    return Law{kAlphaNs * factor, kBetaNs * factor};
  });
  EXPECT_NEAR(scheme.alpha_ns() + 700 * scheme.beta_ns(), 1e6 + 700 * 3000, 0.3e6);
}

TEST(Deadline, AnAlgorithmThatReturnsAtOnceGetsEverything) {
  for (const Execution execution : {Execution::anytime, Execution::whole}) {
    Deadline scheme;
    const auto run =
        run_steady(scheme, execution, 1, 5 * kMs, [](std::size_t) { return Law{0, 1e-9}; });
    EXPECT_EQ(run.kept, 1.0);
    EXPECT_EQ(run.stale, 0u);
  }
}

TEST(Deadline, AnImpossibleBoundIsMetAsWellAsPossible) {
  Deadline scheme({.latency_ms = 1});
  const auto run = run_steady(scheme, Execution::anytime, 1, 4000 * kMs,
                              [](std::size_t) { return Law{2e6, kBetaNs}; });
  EXPECT_LE(run.latency_ns, 1.01 * 8e6);  // 4 alpha
  EXPECT_GT(run.kept, 0.3);
}

TEST(Deadline, AlwaysDecidesSomethingValid) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const CounterRandom random(seed);
    const auto power = [&](std::uint64_t i, double decades) {
      return std::pow(10.0, decades * random.uniform(i));
    };
    Deadline scheme({.latency_ms = 0.01 * power(1000, 9),
                     .overhead = random.uniform(1001),
                     .min_interval_ms = seed % 3 == 0 ? 0 : power(1002, 7),
                     .knee = seed % 2 == 0 ? 0 : power(1003, 6),
                     .first_alpha_us = 0.001 * power(1005, 12),
                     .first_beta_ns = 0.001 * power(1006, 12)});
    scheme.reset(seed % 5 == 0 ? Execution::whole : Execution::anytime);
    for (std::uint64_t k = 0; k < 100; ++k) {
      const FakeBacklog events = evenly(static_cast<std::size_t>(power(9 * k, 3)),
                                        static_cast<std::int64_t>(power(9 * k + 1, 11)));
      Backlog backlog = events.at(kNow, random(9 * k + 2) % 2 == 0);
      backlog.previous_start_ns = kNow - static_cast<std::int64_t>(power(9 * k + 3, 10));
      if (random(9 * k + 4) % 16 == 0) backlog.previous_start_ns = kLongAgo;
      const Decision decision = scheme.decide(backlog);
      if (decision.takes) {
        ASSERT_TRUE((decision.raw >= 1) != (decision.stale >= 1)) << seed;
        ASSERT_LE(decision.raw + decision.stale, backlog.count);
        ASSERT_GE(decision.keep, 0.0);
        ASSERT_LE(decision.keep, 1.0);
        ASSERT_GE(decision.budget_ns, 1);
        ASSERT_TRUE(std::isfinite(decision.event_ns));
      } else {
        ASSERT_FALSE(backlog.due);
        ASSERT_TRUE(decision.until_ns > kNow);
      }
      observe(scheme, static_cast<std::size_t>(power(9 * k + 5, 12)) - 1, backlog.count,
              power(9 * k + 6, 18) - 1);
    }
  }
}

// ---- the class --------------------------------------------------------------------------------

TEST(Deadline, ATakeThatKeptNothingTeachesNothing) {
  Deadline scheme;
  scheme.reset(Execution::anytime);
  const FakeBacklog events = evenly(900'000, 5 * kMs);
  decide(scheme, events);
  observe(scheme, 0, 50, 0);
  EXPECT_EQ(scheme.alpha_ns(), 50e3);
  EXPECT_EQ(scheme.beta_ns(), 100.0);
  EXPECT_EQ(decide(scheme, events).most_event_ns, std::numeric_limits<double>::infinity());
}

TEST(Deadline, ResetBringsTheFirstStateBack) {
  const auto decisions = [](Deadline& scheme) {
    std::vector<double> numbers;
    for (int k = 0; k < 50; ++k) {
      const Decision decision = decide(scheme, evenly(50'000, 5 * kMs));
      numbers.push_back(size_of(decision));
      numbers.push_back(budget_ms(decision));
      observe(scheme, 1000 + static_cast<std::size_t>(100 * k), 20'000, 4e5 + 3e4 * k);
    }
    return numbers;
  };
  Deadline scheme;
  for (const Execution execution : {Execution::anytime, Execution::whole}) {
    scheme.reset(execution);
    const std::vector<double> once = decisions(scheme);
    scheme.reset(execution);
    EXPECT_EQ(scheme.alpha_ns(), 50e3);
    EXPECT_EQ(decisions(scheme), once);
  }
}

TEST(Deadline, TellsItsNameAndParameters) {
  EXPECT_EQ(Deadline().name(), "deadline");
  EXPECT_EQ(Deadline().latency_bound_ns(), 10 * kMs);
  EXPECT_EQ(Deadline({.latency_ms = 2.5}).latency_bound_ns(), 2'500'000);
  EXPECT_EQ(Deadline().parameters(), (SchemeParameters{{"latency_ms", 10.0},
                                                       {"overhead", 0.25},
                                                       {"min_interval_ms", 0.0},
                                                       {"knee", 0.0},
                                                       {"first_alpha_us", 50.0},
                                                       {"first_beta_ns", 100.0}}));
}

TEST(Deadline, RefusesABadConfigurationByName) {
  const auto error = [](DeadlineConfig config) {
    return error_of([=] { Deadline scheme(config); });
  };
  EXPECT_EQ(error({.latency_ms = 0}), "latency_ms = 0: must be between 0.01 and 1e7 ms");
  EXPECT_EQ(error({.overhead = 2}), "overhead = 2: must be between 0 (no limit) and 1");
  EXPECT_EQ(error({.min_interval_ms = -1}), "min_interval_ms = -1: must be between 0 and 1e7 ms");
  EXPECT_EQ(error({.knee = 0.5}), "knee = 0.5: must be 0 (off) or between 1 and 1e6");
  EXPECT_EQ(error({.first_alpha_us = 0}), "first_alpha_us = 0: must be between 0.001 and 1e9 us");
  EXPECT_EQ(error({.first_beta_ns = 0}), "first_beta_ns = 0: must be between 0.001 and 1e9 ns");
}

}  // namespace
}  // namespace asap::deadline_test
