#include "asap/schemes/greedy.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::greedy_test {
namespace {

using test::FakeBacklog;

void observe(Greedy& scheme, std::size_t size, std::int64_t processing_ns) {
  scheme.observe(
      {.size = size, .raw = size, .span_ns = 0, .start_ns = 0, .processing_ns = processing_ns});
}

TEST(Greedy, TakesAllThatWaitsAtOnce) {
  Greedy scheme;
  for (const std::size_t count : {1u, 2u, 1000u, 100'000u}) {
    const auto backlog = FakeBacklog::of(count);
    for (const bool due : {false, true}) {
      const Decision decision = scheme.decide(backlog.at(0, due));
      EXPECT_TRUE(decision.takes);
      EXPECT_EQ(decision.raw, count);
      EXPECT_EQ(decision.keep, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    }
    observe(scheme, count, 1'000'000);
  }
}

// eta / (1 - eta) alpha / beta, and before the first package 50 us + 100 ns per event are assumed.
TEST(Greedy, TheEfficiencyCapsThePackage) {
  for (const auto& [efficiency, cap] : {std::pair{0.5, 500u}, {0.75, 1500u}, {0.9375, 7500u}}) {
    Greedy scheme({.efficiency = efficiency});
    for (const bool due : {false, true}) {
      const Decision decision = scheme.decide(FakeBacklog::of(10'000).at(0, due));
      EXPECT_TRUE(decision.takes);
      EXPECT_EQ(decision.raw, cap);
      EXPECT_EQ(decision.keep, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    }
    EXPECT_EQ(scheme.decide(FakeBacklog::of(cap).at(0)).raw, cap);
    EXPECT_EQ(scheme.decide(FakeBacklog::of(cap - 1).at(0)).raw, cap - 1);
    EXPECT_EQ(scheme.decide(FakeBacklog::of(3).at(0)).raw, 3u);
  }
}

TEST(Greedy, TheCapIsThatOfTheCostThatItMeets) {
  Greedy scheme({.efficiency = 0.9});
  for (int k = 0; k < 200; ++k) {
    const std::size_t size = std::size_t{100} << (k % 7);
    observe(scheme, size, static_cast<std::int64_t>(200'000 + 300 * size));
  }
  const auto raw = static_cast<double>(scheme.decide(FakeBacklog::of(50'000).at(0)).raw);
  EXPECT_NEAR(raw, 9 * 200.0 / 0.3, 60.0);
  scheme.reset(Execution::whole);
  EXPECT_EQ(scheme.decide(FakeBacklog::of(50'000).at(0)).raw, 4500u);
}

TEST(Greedy, TakesAtLeastOneWhateverItMeets) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  Greedy scheme({.efficiency = 1e-6});
  EXPECT_EQ(scheme.decide(FakeBacklog::of(9).at(0)).raw, 1u);
  for (const std::int64_t processing_ns : {std::int64_t{0}, std::int64_t{-1}, kMax, -kMax}) {
    for (const std::size_t size : {0u, 1u, 1'000'000u}) {
      for (int k = 0; k < 5; ++k) observe(scheme, size, processing_ns);
      const std::size_t raw = scheme.decide(FakeBacklog::of(9).at(0)).raw;
      EXPECT_GE(raw, 1u);
      EXPECT_LE(raw, 9u);
    }
  }
}

TEST(Greedy, ATakeThatKeptNothingTeachesNothing) {
  Greedy scheme({.efficiency = 0.5});
  for (int k = 0; k < 50; ++k) observe(scheme, 0, 0);
  EXPECT_EQ(scheme.decide(FakeBacklog::of(10'000).at(0)).raw, 500u);
}

TEST(Greedy, TellsItsNameAndParameters) {
  EXPECT_EQ(Greedy().name(), "greedy");
  EXPECT_TRUE(Greedy().parameters().empty());
  EXPECT_EQ(Greedy({.efficiency = 0.97}).parameters(), (SchemeParameters{{"efficiency", 0.97}}));
}

TEST(Greedy, RefusesABadEfficiency) {
  const auto error = [](double efficiency) {
    return test::error_of([=] { Greedy scheme({.efficiency = efficiency}); });
  };
  const std::string remedy = ": must lie between 0 and 1, or be left out for no cap";
  EXPECT_EQ(error(0.0), "efficiency = 0" + remedy);
  EXPECT_EQ(error(1.0), "efficiency = 1" + remedy);
  EXPECT_EQ(error(-0.5), "efficiency = -0.5" + remedy);
  EXPECT_EQ(error(std::numeric_limits<double>::quiet_NaN()), "efficiency = nan" + remedy);
}

}  // namespace
}  // namespace asap::greedy_test
