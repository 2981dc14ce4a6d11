// Anytime packages, outages and admission in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/greedy.hpp"
#include "core/random.hpp"
#include "runner/admission.hpp"
#include "runner/agreement.hpp"
#include "runner/naive_simulator.hpp"
#include "runner/run.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::simulator_anytime_test {
namespace {

using namespace std::chrono_literals;

using test::at_times;
using test::evenly_spaced;
using test::Events;
using test::NaiveConfig;
using test::NaiveSimulator;
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

// One run, and the same one event by event.
void agree(Scheme& scheme, Scheme& naive_scheme, const LinearCostConfig& cost, EventSpan events,
           std::size_t largest, NaiveConfig config) {
  Events delivered;
  std::unique_ptr<Simulator> simulator;
  simulator = Admission::simulator(
      scheme, LinearCost(cost),
      {.latency = std::chrono::nanoseconds(config.bound_ns),
       .capacity = config.capacity,
       .seed = config.seed,
       .execution = config.execution,
       .flush = config.flush},
      [&](const Package& package) {
        ASSERT_EQ(package.index, simulator->log().size());
        ASSERT_FALSE(package.continues);
        delivered.insert(delivered.end(), package.events.begin(), package.events.end());
      },
      dynamic_cast<Admission*>(&scheme));
  feed_in_chunks(*simulator, events, largest);
  NaiveSimulator naive(naive_scheme, LinearCost(cost), config);
  naive.run(events);
  test::expect_agreement(*simulator, naive);
  ASSERT_TRUE(delivered == naive.delivered);
}

TEST(SimulatorAnytime, AgreesWithTheNaiveSimulatorWhateverIsDecided) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Events events = test::random_stream(seed, 5000);
    const std::size_t largest[] = {1, 3, 100, 2000, events.size()};
    const std::size_t capacities[] = {7, 300, 1500, std::size_t{1} << 20};
    for (const LinearCostConfig& cost : costs_of(seed)) {
      for (const std::size_t capacity : capacities) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", alpha " << cost.alpha_us
                                        << ", capacity " << capacity);
        ScriptedScheme scheme(at_random(seed));
        ScriptedScheme naive_scheme(at_random(seed));
        agree(scheme, naive_scheme, cost, events, largest[seed % 5],
              {.bound_ns = 5 * kMillisecond,
               .capacity = capacity,
               .seed = seed,
               .execution = seed % 4 == 3 ? Execution::whole : Execution::anytime,
               .flush = seed % 3 != 2});
        if (HasFailure()) return;
        EXPECT_EQ(scheme.execution, naive_scheme.execution);
        ASSERT_EQ(scheme.outcomes.size(), naive_scheme.outcomes.size());
        for (std::size_t i = 0; i < scheme.outcomes.size(); ++i) {
          ASSERT_EQ(scheme.outcomes[i].size, naive_scheme.outcomes[i].size) << i;
          ASSERT_EQ(scheme.outcomes[i].raw, naive_scheme.outcomes[i].raw) << i;
          ASSERT_EQ(scheme.outcomes[i].span_ns, naive_scheme.outcomes[i].span_ns) << i;
          ASSERT_EQ(scheme.outcomes[i].processing_ns, naive_scheme.outcomes[i].processing_ns) << i;
        }
      }
    }
  }
}

// Overflow included: what did not fit into the ring is not counted.
TEST(SimulatorAnytime, CountsByAgeSlotsAreRightToASlot) {
  constexpr std::int64_t kBound_ns = 5 * kMillisecond;
  const std::int64_t width_ns = kBound_ns / 64;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const CounterRandom random(seed);
    std::uint64_t asked = 0;
    ScriptedScheme scheme([&](const Backlog& backlog) {
      for (int i = 0; i < 8; ++i) {
        const std::int64_t time_ns =
            backlog.now_ns - static_cast<std::int64_t>(random(asked++) % (2 * kBound_ns));
        const auto counts = [&](std::int64_t t_ns) { return backlog.counts.before(t_ns); };
        const std::int64_t slot_ns = time_ns - (time_ns % width_ns + width_ns) % width_ns;
        const std::size_t exact = counts(time_ns);
        const std::size_t about = backlog.counts.about_before(time_ns);
        EXPECT_LE(std::max(about, exact) - std::min(about, exact),
                  counts(slot_ns + width_ns) - counts(slot_ns));
      }
      EXPECT_EQ(backlog.counts.about_before(backlog.now_ns + 1), backlog.count);
      EXPECT_EQ(backlog.counts.about_before(backlog.now_ns - 1000 * kBound_ns), 0u);
      std::array<std::size_t, 40> older;
      const std::int64_t step_ns = kBound_ns / 37;
      backlog.counts.about_before_each(backlog.now_ns, step_ns, older);
      for (std::size_t i = 0; i < older.size(); ++i) {
        const std::int64_t time_ns = backlog.now_ns - static_cast<std::int64_t>(i) * step_ns;
        EXPECT_EQ(older[i], backlog.counts.about_before(time_ns)) << i;
      }
      return Decision::take(1 + random(asked++) % backlog.count);
    });
    Simulator simulator(scheme, LinearCost({.alpha_us = 100, .beta_ns = 10'000}),
                        {.latency = 5000us, .capacity = 200});
    feed_in_chunks(simulator, test::random_stream(seed, 5000), 300);
    EXPECT_GT(simulator.ledger().overflow, 100u);
    EXPECT_GT(asked, 1000u);
  }
}

// ---- a package against its budget

ScriptedScheme::Rule all_within(std::int64_t budget_ns, double event_ns) {
  return [=](const Backlog& backlog) {
    Decision take = Decision::take(backlog.count);
    take.budget_ns = budget_ns;
    take.event_ns = event_ns;
    return take;
  };
}

TEST(SimulatorAnytime, AnOutageEndsAPackageEarlyAndLeavesTheRestInTheRing) {
  // 1600 events at 1 us: 16 strata of 100. The outage begins in the fifth one.
  const LinearCostConfig cost{
      .alpha_us = 1, .beta_ns = 1000, .outages = {{450 * kMicrosecond, 9 * kMillisecond}}};
  ScriptedScheme scheme(all_within(2 * kMillisecond, 1000));
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

// ---- admission

// Filters on arrival, and decides like a rule.
class Admitting final : public Scheme, public Admission {
 public:
  using Gamma = std::function<double(const Arrivals&)>;

  Admitting(ScriptedScheme::Rule rule, Gamma gamma, std::int64_t period_ns)
      : rule_(std::move(rule)), gamma_(std::move(gamma)), period_ns_(period_ns) {}

  Decision decide(const Backlog& backlog) noexcept override {
    return exempt([&] { return rule_(backlog); });
  }
  std::string_view name() const noexcept override { return "admitting"; }
  double gamma(const Arrivals& arrivals) noexcept override {
    told.push_back(arrivals);
    return gamma_(arrivals);
  }
  std::int64_t period_ns() const noexcept override { return period_ns_; }

  std::vector<Arrivals> told;

 private:
  ScriptedScheme::Rule rule_;
  Gamma gamma_;
  std::int64_t period_ns_;
};

// Less the more waits, and nothing while it waits for long.
double by_backlog(const Arrivals& arrivals) {
  if (arrivals.now_ns - arrivals.oldest_ns > 2 * kMillisecond) return 0.0;
  return 1.0 / (1.0 + 0.01 * static_cast<double>(arrivals.waiting + arrivals.arrived));
}

TEST(SimulatorAnytime, AdmissionAgreesWithTheNaiveSimulator) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Events events = test::random_stream(seed, 5000);
    const std::size_t largest[] = {1, 3, 100, 2000, events.size()};
    for (const LinearCostConfig& cost : costs_of(seed)) {
      for (const std::int64_t period_ns : {kMillisecond / 8, 3 * kMillisecond + 1}) {
        SCOPED_TRACE(testing::Message()
                     << "seed " << seed << ", alpha " << cost.alpha_us << ", " << period_ns);
        Admitting scheme(at_random(seed), by_backlog, period_ns);
        Admitting naive_scheme(at_random(seed), by_backlog, period_ns);
        agree(scheme, naive_scheme, cost, events, largest[seed % 5],
              {.bound_ns = 5 * kMillisecond,
               .capacity = 300,
               .seed = seed,
               .execution = seed % 2 == 0 ? Execution::anytime : Execution::whole,
               .admission = &naive_scheme});
        if (HasFailure()) return;
        ASSERT_EQ(scheme.told.size(), naive_scheme.told.size());
        for (std::size_t i = 0; i < scheme.told.size(); ++i) {
          ASSERT_EQ(scheme.told[i].now_ns, naive_scheme.told[i].now_ns) << i;
          ASSERT_EQ(scheme.told[i].arrived, naive_scheme.told[i].arrived) << i;
          ASSERT_EQ(scheme.told[i].waiting, naive_scheme.told[i].waiting) << i;
          ASSERT_EQ(scheme.told[i].oldest_ns, naive_scheme.told[i].oldest_ns) << i;
        }
      }
    }
  }
}

ScriptedScheme::Rule greedy() {
  return [](const Backlog& backlog) { return Decision::take(backlog.count); };
}

TEST(SimulatorAnytime, ALongSilenceIsNotAskedForAtEveryPeriod) {
  Admitting scheme(greedy(), [](const Arrivals&) { return 1.0; }, kMillisecond);
  const auto simulator =
      Admission::simulator(scheme, LinearCost({.alpha_us = 1, .beta_ns = 1}), {}, {}, &scheme);
  simulator->feed(test::at_times({0, 1'000'000'000}));
  simulator->finish();
  EXPECT_EQ(simulator->ledger().delivered, 2u);
  EXPECT_LE(scheme.told.size(), 100'010u) << "of a million";
}

struct Trouble {};

TEST(SimulatorAnytime, AnExceptionLeavesABalancedLedgerBehindAGate) {
  for (const std::size_t chunk : {1u, 10u, 1000u}) {
    for (const int last : {1, 2, 5, 30}) {
      Admitting scheme(greedy(), [](const Arrivals&) { return 0.7; }, kMillisecond);
      int calls = 0;
      const auto simulator = Admission::simulator(
          scheme, LinearCost({.alpha_us = 100, .beta_ns = 10'000}), {},
          [&](const Package&) {
            if (++calls == last) throw Trouble{};
          },
          &scheme);
      Events events = evenly_spaced(1000, 30);
      for (std::size_t i = 500; i < events.size(); ++i) events[i].t += 20'000;  // a silence
      EXPECT_THROW(feed_in_chunks(*simulator, events, chunk), Trouble);
      EXPECT_EQ(calls, last);
      const Ledger ledger = simulator->ledger();
      EXPECT_TRUE(ledger.balanced());
      EXPECT_GT(ledger.pending, 0u);
      EXPECT_EQ(simulator->log().size(), static_cast<std::size_t>(last) - 1);
    }
  }
}

}  // namespace
}  // namespace asap::simulator_anytime_test
