#include "asap/schemes/greedy.hpp"

#include <gtest/gtest.h>

#include "support/fake_backlog.hpp"

namespace asap::greedy_test {
namespace {

using test::FakeBacklog;

void observe(Greedy& scheme, std::size_t size, std::int64_t processing_ns) {
  scheme.observe(
      {.size = size, .raw = size, .span_ns = 0, .start_ns = 0, .processing_ns = processing_ns});
}

// eta / (1 - eta) alpha / beta, and before the first package 50 us + 100 ns per event are assumed.
TEST(Greedy, TheEfficiencyCapsThePackage) {
  for (const auto& [efficiency, cap] : {std::pair{0.5, 500u}, {0.75, 1500u}, {0.9375, 7500u}}) {
    Greedy scheme({.efficiency = efficiency});
    for (const bool due : {false, true}) {
      const Decision decision = scheme.decide(FakeBacklog::of(10'000).at(0, due));
      EXPECT_TRUE(decision.takes);
      EXPECT_EQ(decision.raw, cap);
      EXPECT_EQ(decision.gamma, 1.0);
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

}  // namespace
}  // namespace asap::greedy_test
