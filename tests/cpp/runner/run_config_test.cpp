#include "asap/runner/run_config.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/greedy.hpp"
#include "support/errors.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::run_config_test {
namespace {

using namespace std::chrono_literals;

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
  EXPECT_EQ(latency_bound_ns({.latency = 2500us}, greedy), 2'500'000);
  EXPECT_EQ(latency_bound_ns({}, with_bound), 5'000'000);
  EXPECT_EQ(latency_bound_ns({.latency = 5000us}, with_bound), 5'000'000);
}

// To the nanosecond: the two are one type.
TEST(RunConfig, RefusesABoundThatIsNotTheSchemes) {
  const Deadline scheme({.latency = 15'659ns});
  EXPECT_EQ(latency_bound_ns({.latency = 15'659ns}, scheme), 15'659);
  EXPECT_EQ(test::error_of([&] { (void)latency_bound_ns({.latency = 15'658ns}, scheme); }),
            "latency = 0.015658 ms: differs from the bound of the scheme; give one of the two");
}

// A bare number is no time.
static_assert(!std::is_convertible_v<double, decltype(RunConfig::latency)>);
static_assert(!std::is_convertible_v<int, decltype(RunConfig::latency)>);
static_assert(!std::is_convertible_v<int, decltype(DeadlineConfig::latency)>);

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
