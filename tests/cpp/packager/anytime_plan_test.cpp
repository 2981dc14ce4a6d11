#include "packager/anytime_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace asap::anytime_plan_test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Decision within(std::int64_t budget_ns, std::size_t raw, double event_ns = 0.0,
                double gamma = 1.0) {
  Decision decision = Decision::take(raw, gamma);
  decision.budget_ns = budget_ns;
  decision.event_ns = event_ns;
  return decision;
}

// The strata of a package whose events cost nothing.
std::vector<AnytimePlan::Stratum> strata_of(const Decision& decision) {
  AnytimePlan plan(decision, 0, kMillisecond);
  std::vector<AnytimePlan::Stratum> strata;
  for (auto next = plan.next(0, 0); next.begin != next.end; next = plan.next(0, 0)) {
    strata.push_back(next);
  }
  return strata;
}

TEST(AnytimePlan, CutsTheRawEventsIntoStrataOfEqualCount) {
  for (const std::size_t raw :
       {1u, 2u, 63u, 64u, 127u, 128u, 200u, 777u, 1023u, 1024u, 1025u, 9999u, 1'000'003u}) {
    const auto strata = strata_of(within(kMillisecond, raw));
    ASSERT_EQ(strata.size(), std::clamp<std::size_t>(raw / 64, 1, 16)) << raw;
    for (std::size_t j = 0; j < strata.size(); ++j) {
      EXPECT_EQ(strata[j].begin, raw * j / strata.size());
      EXPECT_EQ(strata[j].end, raw * (j + 1) / strata.size());
      EXPECT_EQ(strata[j].is_last, j + 1 == strata.size());
      EXPECT_LE(strata[j].end - strata[j].begin, AnytimePlan::longest_stratum(raw));
    }
  }
}

// k0 = 6400 / 32: the expectation counts as 200 events.
TEST(AnytimePlan, WeighsTheExpectationAgainstWhatThePackageHasShown) {
  AnytimePlan plan(within(2 * kMillisecond, 6400, 1000.0), 7, kMillisecond);
  EXPECT_DOUBLE_EQ(plan.next(7, 0).gamma, 2e6 / 16 / 1000 / 400);
  // 100 events in 300 us.
  const double b = (200 * 1000.0 + 300'000) / (200 + 100);
  EXPECT_DOUBLE_EQ(plan.next(300'007, 100).gamma, 1.7e6 / 15 / b / 400);
  // 50 more in 20 us.
  const double c = (200 * 1000.0 + 320'000) / (200 + 150);
  EXPECT_DOUBLE_EQ(plan.next(320'007, 50).gamma, 1.68e6 / 14 / c / 400);
}

Decision with_fixed_cost(double fixed_ns, Decision decision) {
  decision.fixed_ns = fixed_ns;
  return decision;
}

TEST(AnytimePlan, TheOnlyStratumLeavesTimeForTheFixedCost) {
  const Decision decision = with_fixed_cost(940'000, within(kMillisecond, 100, 1000));
  EXPECT_DOUBLE_EQ(AnytimePlan(decision, 5, 0).next(5, 0).gamma, 0.6);
  EXPECT_DOUBLE_EQ(AnytimePlan(decision, 5, 0).next(300'005, 0).gamma, 0.6) << "partly over";
  EXPECT_DOUBLE_EQ(AnytimePlan(decision, 5, 0).next(950'005, 0).gamma, 0.5) << "over";
}

TEST(AnytimePlan, AFixedCostBeyondTheBudgetLeavesTheLeast) {
  // If it is true, the package is late anyway; if not, its time tells the cost model so.
  const Decision decision = with_fixed_cost(1'500'000, within(kMillisecond, 100, 0.1));
  EXPECT_DOUBLE_EQ(AnytimePlan(decision, 5, 0).next(5, 0).gamma, 0.02) << "2 % of the plan: 2";
  const Decision small = with_fixed_cost(1'500'000, within(kMillisecond, 20, 0.1));
  EXPECT_DOUBLE_EQ(AnytimePlan(small, 5, 0).next(5, 0).gamma, 1.0 / 20);
}

// An event is expected to cost 1 us, which weighs as 200 events; the first stratum, of 100, takes
// 500 us in all.
TEST(AnytimePlan, WhatTheFixedCostTakesIsNotTheEvents) {
  const auto second = [](double fixed_ns) {
    AnytimePlan plan(with_fixed_cost(fixed_ns, within(2 * kMillisecond, 6400, 1000.0)), 7, 0);
    EXPECT_DOUBLE_EQ(plan.next(7, 0).gamma, 2e6 / 16 / 1000 / 400);
    return plan.next(500'007, 100).gamma;
  };
  const auto planned = [](double events_ns) {
    return 1.5e6 / 15 / ((200'000 + events_ns) / 300) / 400;
  };
  EXPECT_DOUBLE_EQ(second(0), planned(500'000));
  EXPECT_DOUBLE_EQ(second(200'000), planned(300'000));
  EXPECT_DOUBLE_EQ(second(450'000), planned(100'000)) << "not less than was expected of them";
  EXPECT_DOUBLE_EQ(second(1e9), planned(100'000));
}

TEST(AnytimePlan, AFixedCostThatHasPassedBeforeIsNotLookedForAgain) {
  const auto second = [](std::int64_t first_ns) {
    AnytimePlan plan(with_fixed_cost(400'000, within(2 * kMillisecond, 6400, 1000.0)), 0, 0);
    (void)plan.next(first_ns, 0);
    return plan.next(first_ns + 300'000, 100).gamma;
  };
  EXPECT_DOUBLE_EQ(second(210'000), 1.49e6 / 15 / (500'000.0 / 300) / 400);
  EXPECT_DOUBLE_EQ(second(190'000), 1.51e6 / 15 / (300'000.0 / 300) / 400) << "most is to come";
}

// Strata of a package of so many events that need work_ns in all, or may need it.
std::size_t strata(std::size_t raw, std::int64_t budget_ns, double work_ns, bool may = false) {
  Decision decision = within(budget_ns, raw, may ? 1.0 : work_ns / static_cast<double>(raw));
  if (may) decision.max_event_ns = work_ns / static_cast<double>(raw);
  return strata_of(decision).size();
}

TEST(AnytimePlan, NoStratumOfDearEventsIsLongerThanItsShareOfTheBudget) {
  for (const bool may : {false, true}) {
    EXPECT_EQ(strata(100, 1'600'000, 199'000, may), 1u);
    EXPECT_EQ(strata(100, 1'600'000, 201'000, may), 2u);
    EXPECT_EQ(strata(100, 1'600'000, 1'590'000, may), 15u);
    EXPECT_EQ(strata(100, 1'600'000, 1'610'000, may), 16u);
    EXPECT_EQ(strata(100, 1'600'000, 1e12, may), may ? 17u : 16u) << "one event before the others";
    EXPECT_EQ(strata(5, 1'600'000, 1e12, may), 5u) << "one event is the least";
    EXPECT_EQ(strata(320, 1'600'000, 301'000, may), 5u) << "64 events each are shorter";
    EXPECT_EQ(strata(100, 9000, 1e12, may), may ? 5u : 4u)
        << "2 us: reading the clock must cost nothing";
    EXPECT_EQ(strata(100, 1000, 1e12, may), 1u);
  }
}

TEST(AnytimePlan, AnExpectationThatIsDoubtedWeighsLess) {
  Decision decision = within(kMillisecond, 6400, 100.0);
  const auto second = [&](double max_ns) {
    decision.max_event_ns = max_ns;
    AnytimePlan plan(decision, 0, 0);
    std::int64_t now_ns = 0;
    AnytimePlan::Stratum stratum = plan.next(0, 0);
    now_ns += 1000 * static_cast<std::int64_t>(stratum.end);
    return plan.next(now_ns, stratum.end).gamma * 400;  // in strata of 400
  };
  const double time_ns = 1e6 - 400e3;
  EXPECT_DOUBLE_EQ(second(0), time_ns / 15 / ((200 * 100.0 + 400e3) / 600));
  EXPECT_DOUBLE_EQ(second(125), time_ns / 15 / ((160 * 100.0 + 400e3) / 560));
}

TEST(AnytimePlan, ALatePackageGoesOnAtItsFloor) {
  AnytimePlan plan(within(kMillisecond, 6400, 1000.0), 0, kMillisecond);
  (void)plan.next(0, 0);
  EXPECT_DOUBLE_EQ(plan.next(kMillisecond + 1, 10).gamma, 0.02);
  EXPECT_DOUBLE_EQ(plan.next(2 * kMillisecond, 8).gamma, 0.02);
}

TEST(AnytimePlan, AnOutageEndsThePackageBeyondItsGrace) {
  constexpr std::int64_t kStart_ns = 5 * kMillisecond;
  AnytimePlan on_time(within(kMillisecond, 6400), kStart_ns, 500);
  EXPECT_EQ(on_time.next(kStart_ns, 0).end, 400u);
  EXPECT_EQ(on_time.next(kStart_ns + kMillisecond + 500, 1).end, 800u);
  const AnytimePlan::Stratum none = on_time.next(kStart_ns + kMillisecond + 501, 1);
  EXPECT_EQ(none.begin, none.end);
}

TEST(AnytimePlan, WhereItMightTakeTooLongTheFirstStratumBeginsWithAFew) {
  Decision decision = within(1'600'000, 1600, 100.0);  // as expected 10 us a stratum, of 100 us
  const auto first_end = [&](double max_event_ns) {
    decision.max_event_ns = max_event_ns;
    return strata_of(decision)[0].end;
  };
  EXPECT_EQ(first_end(10'000), 10u);
  EXPECT_EQ(strata_of(decision).size(), 17u);
  EXPECT_EQ(strata_of(decision)[0].gamma, 1.0);
  EXPECT_EQ(strata_of(decision)[1].end, 100u);
  EXPECT_EQ(first_end(kInfinity), 1u);
  EXPECT_EQ(first_end(1000), 100u) << "then it would fit";
  decision.gamma = 0.01;
  EXPECT_EQ(first_end(10'000), 10u) << "the clock may allow more than was planned";
  decision.event_ns = 10'000;
  EXPECT_EQ(first_end(10'000), 100u) << "no doubt";
}

TEST(AnytimePlan, TellsWhatItWasUntilTheEndOfTheFirstStratum) {
  AnytimePlan plan(within(kMillisecond, 6400, 100.0), 7, 0);
  (void)plan.next(1007, 0);  // a fixed cost, paid before
  EXPECT_EQ(plan.first().size, 0u);
  (void)plan.next(50'007, 300);
  (void)plan.next(90'007, 200);
  EXPECT_EQ(plan.first().size, 300u);
  EXPECT_EQ(plan.first().time_ns, 50'000);
  AnytimePlan one(within(kMillisecond, 60, 100.0), 0, 0);
  (void)one.next(0, 0);
  (void)one.next(6000, 60);
  EXPECT_EQ(one.first().size, 0u) << "there are not two sizes";
}

// Strata of 100 us each, all of 400 events, on top of which stratum j takes extra_ns(j).
std::int64_t outage_ns(std::size_t strata, const std::function<std::int64_t(std::size_t)>& extra) {
  AnytimePlan plan(within(100 * kMillisecond, 6400, 250.0), 0, kMillisecond / 10);
  std::int64_t now_ns = 0;
  (void)plan.next(now_ns, 0);
  for (std::size_t j = 0; j < strata; ++j) {
    now_ns += 100'000 + extra(j);
    (void)plan.next(now_ns, 400);
  }
  return plan.outage_ns();
}

TEST(AnytimePlan, AStratumThatTakesFarTooLongHasMetAnOutage) {
  const auto at = [](std::size_t first, std::int64_t ns) {
    return [=](std::size_t j) { return j == first ? ns : 0; };
  };
  for (const std::size_t j : {1u, 7u, 14u, 15u}) {
    EXPECT_EQ(outage_ns(16, at(j, 4 * kMillisecond)), 4 * kMillisecond) << j;
  }
  EXPECT_EQ(outage_ns(8, at(7, 4 * kMillisecond)), 4 * kMillisecond);  // it ended the package
  EXPECT_EQ(outage_ns(16, at(3, 190'000)), 0);                         // algorithms vary
  EXPECT_EQ(outage_ns(16, at(3, 210'000)), 210'000);
  const auto twice = [](std::size_t j) { return j % 5 == 3 ? 2 * kMillisecond : 0; };
  EXPECT_EQ(outage_ns(16, twice), 6 * kMillisecond);  // 3, 8, 13
}

TEST(AnytimePlan, TheFixedCostIsNoOutage) {
  EXPECT_EQ(outage_ns(16, [](std::size_t j) { return j == 0 ? 4 * kMillisecond : 0; }), 0);
}

TEST(AnytimePlan, DearEventsAreNoOutage) {
  for (const std::size_t from : {1u, 6u, 14u}) {
    const auto rise = [=](std::size_t j) { return j >= from ? 9 * kMillisecond / 10 : 0; };
    EXPECT_EQ(outage_ns(16, rise), 0) << from;
  }
}

// Far too long for its events, but so short that only a late package has such strata.
TEST(AnytimePlan, WhatIsShorterThanTheGraceIsNoOutage) {
  AnytimePlan plan(within(kMillisecond, 6400, 250.0), 0, kMillisecond);
  (void)plan.next(0, 0);
  (void)plan.next(100'000, 400);
  (void)plan.next(100'000, 0);  // an empty stratum says nothing
  (void)plan.next(600'000, 8);
  EXPECT_EQ(plan.outage_ns(), 0);
}

TEST(AnytimePlan, AlwaysPlansAFraction) {
  for (const double event_ns : {0.0, 1e-300, 1e300, kInfinity, kNaN, -kInfinity}) {
    for (const double max_ns : {0.0, 1.0, kInfinity, kNaN, -kInfinity}) {
      Decision decision = within(kMillisecond, 100, event_ns);
      decision.max_event_ns = max_ns;
      const auto strata = strata_of(decision);
      ASSERT_LE(strata.size(), 17u);
      ASSERT_EQ(strata.back().end, 100u);
    }
    for (const std::int64_t budget_ns : {kLongAgo, std::int64_t{0}, kMillisecond, kNever}) {
      for (const double gamma : {0.0, 1e-300, 1.0}) {
        for (const std::int64_t start_ns : {std::int64_t{-9'200'000'000'000'000'000},
                                            std::int64_t{0}, 9'200'000'000'000'000'000}) {
          AnytimePlan plan(with_fixed_cost(event_ns, within(budget_ns, 6400, event_ns, gamma)),
                           start_ns, kMillisecond);
          for (std::int64_t j = 0; j < 16; ++j) {
            const double fraction = plan.next(start_ns + j % 3, j % 2 == 0 ? 0 : 400).gamma;
            ASSERT_GE(fraction, 0.0);
            ASSERT_LE(fraction, 1.0);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace asap::anytime_plan_test
