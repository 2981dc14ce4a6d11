// Anytime packages and outages in virtual time, however the events come: what a package
// holds and what the rows say of it is held by tests/simulation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/greedy.hpp"
#include "core/random.hpp"
#include "runner/run.hpp"
#include "support/gap.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::simulator_anytime_test {
namespace {

using namespace std::chrono_literals;

using test::at_times;
using test::Events;
using test::ScriptedScheme;

constexpr std::int64_t kMicrosecond = 1000;
constexpr std::int64_t kMillisecond = 1'000'000;

// A scheme that decides anything, the same in every run.
ScriptedScheme::Rule at_random(std::uint64_t seed) {
  return [random = CounterRandom(seed), asked = std::uint64_t{0}](const Backlog& backlog) mutable {
    const std::uint64_t bits = random(asked++);
    const auto number = [&](int shift, std::uint64_t limit) { return (bits >> shift) % limit; };
    const auto part = static_cast<std::size_t>(number(8, backlog.count)) + 1;
    if (bits % 8 < 2) {
      Decision wait = Decision::wait_until(backlog.now_ns + 1 +
                                           static_cast<std::int64_t>(number(16, 3'000'000)));
      if (bits % 8 == 0) wait.until_count = backlog.count + 1 + number(40, 200);
      return wait;
    }
    if (bits % 8 == 2) return Decision::drop(part);
    const double keeps[] = {1, 1, 0.5, 0.03, 0, random.uniform(asked)};
    const std::int64_t budgets[] = {kNever, -7, 0, 50'000, 400'000, 3'000'000, kNever - 1};
    const double fixed[] = {0, 0, 30'000, 2e6};
    const double costs[] = {0, 1, 300, 20'000, 1e7};
    Decision take = Decision::take(part, keeps[number(16, 6)]);
    if (number(24, 4) > 0) take.raw = backlog.count;
    if (number(28, 8) == 0) take.raw = 1 + backlog.counts.before(backlog.now_ns - kMillisecond);
    if (number(32, 16) == 0) take.stale = part / 2;
    take.budget_ns = budgets[number(40, 7)];
    take.fixed_ns = fixed[number(52, 4)];
    take.max_event_ns = fixed[number(53, 4)];
    take.event_ns = costs[number(48, 5)];
    return take;
  };
}

LinearCostConfig troubled_cost(std::uint64_t seed) {
  LinearCostConfig config{.alpha_us = 30, .beta_ns = 4000, .noise = 0.4, .seed = seed};
  const CounterRandom random(seed);
  for (std::uint64_t i = 0; i < 2000; ++i) config.drift.push_back(4 * random.uniform(i));
  std::int64_t free_ns = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const std::int64_t begin_ns = free_ns + static_cast<std::int64_t>(random(2 * i) % 20'000'000);
    free_ns = begin_ns + 1 + static_cast<std::int64_t>(random(2 * i + 1) % 6'000'000);
    config.outages.push_back({begin_ns, free_ns});
  }
  return config;
}

std::vector<LinearCostConfig> costs_of(std::uint64_t seed) {
  return {{.alpha_us = 1, .beta_ns = 10},
          {.alpha_us = 0, .beta_ns = 0},
          {.alpha_us = 100, .beta_ns = 20'000, .noise = 1, .seed = seed},
          troubled_cost(seed)};
}

void feed_in_chunks(Simulator& simulator, EventSpan events, std::size_t largest) {
  const CounterRandom random(largest);
  for (std::size_t at = 0; at < events.size();) {
    const std::size_t size = std::min(1 + random(at) % largest, events.size() - at);
    simulator.feed(events.subspan(at, size));
    at += size;
    ASSERT_TRUE(simulator.ledger().balanced());
  }
  simulator.finish();
}

struct Result {
  std::vector<PackageRow> rows;
  std::vector<Slot> slots;
  Events delivered;
  Ledger ledger;
  std::int64_t busy_ns;
};

Result result_of(Scheme& scheme, const LinearCostConfig& cost, const RunConfig& config,
                 EventSpan events, std::size_t largest) {
  Result result;
  Simulator simulator(scheme, LinearCost(cost), config, [&](const Package& package) {
    result.delivered.insert(result.delivered.end(), package.events.begin(), package.events.end());
  });
  feed_in_chunks(simulator, events, largest);
  const RunLog& log = simulator.log();
  for (std::size_t i = 0; i < log.size(); ++i) result.rows.push_back(log[i]);
  result.slots.assign(simulator.slots().begin(), simulator.slots().end());
  result.ledger = simulator.ledger();
  result.busy_ns = simulator.busy_ns();
  EXPECT_EQ(simulator.stats().gap_us,
            test::gap_us({events.begin(), events.end()}, result.delivered));
  return result;
}

template <typename T>
bool are_same_bits(const std::vector<T>& some, const std::vector<T>& others) {
  return some.size() == others.size() &&
         (some.empty() || std::memcmp(some.data(), others.data(), some.size() * sizeof(T)) == 0);
}

void expect_the_same_however_it_comes(const std::function<std::unique_ptr<Scheme>()>& make,
                                      const LinearCostConfig& cost, const RunConfig& config,
                                      EventSpan events) {
  const Result whole = result_of(*make(), cost, config, events, events.size());
  Slot total{};
  for (const Slot& slot : whole.slots) {
    total.received += slot.received;
    total.delivered += slot.delivered;
  }
  ASSERT_EQ(static_cast<std::uint64_t>(total.received), whole.ledger.received);
  ASSERT_EQ(static_cast<std::uint64_t>(total.delivered), whole.ledger.delivered);
  ASSERT_EQ(whole.delivered.size(), whole.ledger.delivered);
  for (const std::size_t largest : {1u, 3u, 100u, 2000u}) {
    const Result cut = result_of(*make(), cost, config, events, largest);
    ASSERT_TRUE(are_same_bits(whole.rows, cut.rows));
    ASSERT_TRUE(are_same_bits(whole.slots, cut.slots));
    ASSERT_TRUE(whole.delivered == cut.delivered);
    ASSERT_EQ(whole.ledger, cut.ledger);
    ASSERT_EQ(whole.busy_ns, cut.busy_ns);
  }
}

TEST(SimulatorAnytime, IsTheSameHoweverTheEventsComeWhateverIsDecided) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Events events = test::random_stream(seed, 2000);
    const std::size_t capacities[] = {7, 300, 1500, std::size_t{1} << 20};
    for (const LinearCostConfig& cost : costs_of(seed)) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", alpha " << cost.alpha_us);
      expect_the_same_however_it_comes(
          [seed] { return std::make_unique<ScriptedScheme>(at_random(seed)); }, cost,
          {.latency = 5ms,
           .capacity = capacities[seed % 4],
           .seed = seed,
           .execution = seed % 4 == 3 ? Execution::whole : Execution::anytime,
           .flush = seed % 3 != 2},
          events);
      if (HasFailure()) return;
    }
  }
}

// ---- a package against its budget

TEST(SimulatorAnytime, AnOutageEndsAPackageEarlyAndLeavesTheRestInTheRing) {
  // 1600 events at 1 us: 16 strata of 100. The outage begins in the fifth one.
  const LinearCostConfig cost{
      .alpha_us = 1, .beta_ns = 1000, .outages = {{450 * kMicrosecond, 9 * kMillisecond}}};
  ScriptedScheme scheme([](const Backlog& backlog) {
    Decision take = Decision::take(backlog.count);
    take.budget_ns = 2 * kMillisecond;
    take.event_ns = 1000;
    return take;
  });
  Simulator simulator(scheme, LinearCost(cost), {.execution = Execution::anytime});
  Events events = at_times({0});
  for (std::size_t i = 0; i < 1600; ++i) events.push_back(test::numbered(i + 1, 1));
  simulator.feed(events);
  simulator.finish();
  const RunLog& log = simulator.log();
  ASSERT_EQ(log.size(), 3u);
  EXPECT_EQ(log[1].start_us, 2);
  EXPECT_EQ(log[1].size, 500);
  EXPECT_EQ(log[1].offered, 500);
  EXPECT_EQ(log[1].processing_us, 9051);
  EXPECT_EQ(log[2].start_us, 9053);
  EXPECT_EQ(log[2].size, 1100);
  EXPECT_EQ(log[2].offered, 1100);
  EXPECT_EQ(simulator.ledger(), (Ledger{.received = 1601, .delivered = 1601}));
  EXPECT_EQ(simulator.busy_ns(), (2 + 9051 + 1101) * kMicrosecond);
  ASSERT_EQ(scheme.outcomes.size(), 3u);
  EXPECT_EQ(scheme.outcomes[0].outage_ns, 0);
  EXPECT_EQ(scheme.outcomes[1].work_ns(), 501 * kMicrosecond);
  EXPECT_EQ(scheme.outcomes[2].outage_ns, 0);
}

}  // namespace
}  // namespace asap::simulator_anytime_test
