#include "asap/runner/run_config.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/greedy.hpp"
#include "support/errors.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::run_config_test {
namespace {

class WithBound final : public Scheme {
 public:
  Decision decide(const Backlog&) noexcept override { return Decision::take(1); }
  std::string_view name() const noexcept override { return "with_bound"; }
  std::int64_t latency_bound_ns() const noexcept override { return 5'000'000; }
};

TEST(RunConfig, TheBoundIsTheUsersElseTheSchemesElseTen) {
  const Greedy greedy;
  const WithBound with_bound;
  EXPECT_EQ(latency_bound_ns({}, greedy), 10'000'000);
  EXPECT_EQ(latency_bound_ns({.latency_us = 2500}, greedy), 2'500'000);
  EXPECT_EQ(latency_bound_ns({}, with_bound), 5'000'000);
  EXPECT_EQ(latency_bound_ns({.latency_us = 5000}, with_bound), 5'000'000);
}

TEST(RunConfig, OneBoundInTwoUnitsIsOneBound) {
  for (std::int64_t ns = 10'000; ns < 60'000; ++ns) {
    const double us = static_cast<double>(ns) * 1e-3 + 0.0005;  // 15.6585 us: rounded up or down
    for (const double ms : {us * 1e-3, us / 1e3}) {
      const Deadline scheme({.latency_ms = ms});
      ASSERT_EQ(latency_bound_ns({.latency_us = us}, scheme), scheme.latency_bound_ns()) << us;
    }
  }
}

TEST(RunConfig, RefusesABadBoundByName) {
  const Greedy greedy;
  const WithBound with_bound;
  const auto error = [](double latency_us, const Scheme& scheme) {
    return test::error_of([&] { (void)latency_bound_ns({.latency_us = latency_us}, scheme); });
  };
  const std::string range = ": must be between 10 and 1e10 us";
  EXPECT_EQ(error(0, greedy), "latency_us = 0" + range);
  EXPECT_EQ(error(-1, greedy), "latency_us = -1" + range);
  EXPECT_EQ(error(1e11, greedy), "latency_us = 100000000000" + range);
  EXPECT_EQ(error(std::numeric_limits<double>::quiet_NaN(), greedy), "latency_us = nan" + range);
  EXPECT_EQ(error(6000, with_bound),
            "latency_us = 6000: differs from the bound of the scheme; give one of the two");
}

TEST(RunConfig, TheRingHoldsTwoBoundsOfTheFastestSensor) {
  EXPECT_EQ(ring_capacity({}, 10'000'000), std::size_t{1} << 21);
  EXPECT_EQ(ring_capacity({}, 1'000'000), std::size_t{1} << 20);
  for (const std::int64_t bound_ns : {1'000'000, 8'000'000, 20'000'000, 100'000'000}) {
    const std::size_t capacity = ring_capacity({}, bound_ns);
    EXPECT_TRUE(std::has_single_bit(capacity));
    EXPECT_GE(static_cast<double>(capacity), 60e6 * 2 * static_cast<double>(bound_ns) * 1e-9);
  }
  EXPECT_EQ(ring_capacity({}, 10'000'000'000'000), std::size_t{1} << 26);
  EXPECT_EQ(ring_capacity({.capacity = 1000}, 10'000'000), 1000u);
}

TEST(RunConfig, TheExecutionAndTheFlushReachTheScheme) {
  std::vector<bool> due;
  test::ScriptedScheme scheme([&](const Backlog& backlog) {
    due.push_back(backlog.due);
    return Decision::wait_for(1000);
  });
  const test::Events events = test::evenly_spaced(3, 50'000);
  for (const Execution execution : {Execution::whole, Execution::anytime}) {
    for (const bool flush : {false, true}) {
      due.clear();
      Simulator simulator(scheme, LinearCost(), {.execution = execution, .flush = flush});
      simulator.feed(events);
      simulator.finish();
      EXPECT_EQ(scheme.execution, execution);
      EXPECT_EQ(std::count(due.begin(), due.end(), true), flush ? 3 : 1);
    }
  }
}

}  // namespace
}  // namespace asap::run_config_test
