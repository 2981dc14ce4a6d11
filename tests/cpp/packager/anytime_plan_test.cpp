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

Decision within(std::int64_t budget_ns, std::size_t raw, double event_ns = 0.0, double keep = 1.0) {
  Decision decision = Decision::take(raw, keep);
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
      for (const double keep : {0.0, 1e-300, 1.0}) {
        for (const std::int64_t start_ns : {std::int64_t{-9'200'000'000'000'000'000},
                                            std::int64_t{0}, 9'200'000'000'000'000'000}) {
          Decision decision = within(budget_ns, 6400, event_ns, keep);
          decision.fixed_ns = event_ns;
          AnytimePlan plan(decision, start_ns, kMillisecond);
          for (std::int64_t j = 0; j < 16; ++j) {
            const double fraction = plan.next(start_ns + j % 3, j % 2 == 0 ? 0 : 400).keep;
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
