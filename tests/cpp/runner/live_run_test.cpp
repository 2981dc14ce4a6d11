// One thread: what is pushed, counted and timed. Two threads: pipeline_test.cpp.
#include "runner/live_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "asap/schemes/greedy.hpp"
#include "support/allocation_counter.hpp"
#include "support/gap.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::live_run_test {
namespace {

using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

void deliver_all(LiveRun& run) {
  Package package;
  while (run.loop().next(package, 0ns) == ConsumerLoop::Next::package) {
    run.loop().complete(package);
  }
}

const RunConfig kWhole{.execution = Execution::whole};

TEST(LiveRun, AgesCountFromTheArrivalWhateverTheStamps) {
  Greedy scheme;
  LiveRun run(scheme, kWhole);
  const auto arrival = Steady::now() - 5s;
  run.push(test::evenly_spaced(100, 1'000'000'000, 77), arrival);  // stamps of 28 hours
  run.push(test::at_times({200'000'000'000}), arrival + 2s);
  deliver_all(run);
  const LatencyHistogram& latency = run.telemetry().latency;
  EXPECT_EQ(latency.count(), 101u);
  EXPECT_GE(latency.max_ns(), 5'000'000'000);
  EXPECT_LT(latency.max_ns(), 50'000'000'000);
  EXPECT_NEAR(latency.mean_ns(), static_cast<double>(latency.max_ns()) - 2e9 / 101, 1e6);
  const PackageRow row = run.telemetry().log[0];
  EXPECT_EQ(row.latency_max_us, static_cast<double>(latency.max_ns()) * 1e-3);
  EXPECT_NEAR(row.start_us + row.processing_us - 77, row.latency_max_us, 1.0)
      << "the run's axis begins with the first arrival at its stamp";
}

TEST(LiveRun, AnArrivalInTheFutureIsNowAndOneBeforeTheLastIsThat) {
  Greedy scheme;
  LiveRun run(scheme, kWhole);
  run.push(test::at_times({1}), Steady::now() - 1s);
  run.push(test::at_times({2}), Steady::now() - 9s);
  deliver_all(run);
  EXPECT_LT(run.telemetry().latency.max_ns(), 5'000'000'000);
  run.push(test::at_times({3}), Steady::now() + 100s);
  deliver_all(run);
  EXPECT_EQ(run.ledger().delivered, 3u);
  EXPECT_LT(run.sensor_delay().max_ns(), 5'000'000'000);
}

TEST(LiveRun, AnArrivalBeforeTheClockBeganIsItsBeginning) {
  Greedy scheme;
  LiveRun run(scheme, kWhole);
  run.push(test::at_times({1}), Steady::time_point::min());
  deliver_all(run);
  EXPECT_EQ(run.ledger().delivered, 1u);
  const std::int64_t uptime_ns = Steady::now().time_since_epoch() / 1ns;
  EXPECT_NEAR(static_cast<double>(run.telemetry().latency.max_ns()), static_cast<double>(uptime_ns),
              20e9);
}

TEST(LiveRun, ATailThatIsSeenLateIsNotOfTheBookedOnes) {
  Greedy scheme;
  LiveRun run(scheme, kWhole);
  run.push(test::evenly_spaced(10, 1));
  // As another processor may see it: the consumer's counts before the producer's tail.
  const_cast<Telemetry&>(run.telemetry()).delivered = 12;
  EXPECT_EQ(run.ledger(), (Ledger{.received = 12, .delivered = 12}));
}

TEST(LiveRun, CountsWhatTheDoorRejects) {
  Greedy scheme;
  RunConfig config = kWhole;
  config.validator = {.width = 50, .height = 50};
  LiveRun run(scheme, config);
  run.push(test::evenly_spaced(60, 10));  // x = 50 ... 59 are outside
  run.push(test::at_times({5}));          // back in time
  EXPECT_EQ(run.rejected().out_of_bounds, 10u);
  EXPECT_EQ(run.rejected().nonmonotonic, 1u);
  EXPECT_EQ(run.ledger(), (Ledger{.received = 61, .rejected = 11, .pending = 50}));
}

TEST(LiveRun, ARefusedEventIsCountedAndSoIsWhatCameBefore) {
  Greedy scheme;
  RunConfig config = kWhole;
  config.validator = {.width = 50, .height = 50, .on_bad = OnBad::raise};
  LiveRun run(scheme, config);
  EXPECT_THROW(run.push(test::evenly_spaced(60, 10), {}), std::invalid_argument);
  EXPECT_EQ(run.ledger(), (Ledger{.received = 51, .rejected = 1, .pending = 50}));
}

TEST(LiveRun, TheNewestThatDoNotFitOverflow) {
  Greedy scheme;
  RunConfig config = kWhole;
  config.capacity = 100;
  config.when_full = WhenFull::newest;
  LiveRun run(scheme, config);
  run.push(test::evenly_spaced(150, 1), {});
  EXPECT_EQ(run.ledger(), (Ledger{.received = 150, .overflow = 50, .pending = 100}));
  Package package;
  ASSERT_EQ(run.loop().next(package, 0ns), ConsumerLoop::Next::package);
  EXPECT_EQ(package.lost_before(), 50u);
  EXPECT_EQ(test::number_of(package.events.front()), 0u);
}

TEST(LiveRun, APackageThatIsCopiedIsBoundedAndTheRestFollows) {
  constexpr std::size_t kEvents = asap::Run::kMaxCopied + 40'000;
  test::ScriptedScheme scheme(
      [](const Backlog& backlog) { return Decision::take(backlog.count, 1 - 1e-9); });
  RunConfig config = kWhole;
  config.capacity = 2 * asap::Run::kMaxCopied;
  LiveRun run(scheme, config);
  run.push(test::evenly_spaced(kEvents, 0), {});
  for (const std::size_t size : {asap::Run::kMaxCopied, kEvents - asap::Run::kMaxCopied}) {
    Package package;
    ASSERT_EQ(run.loop().next(package, 0ns), ConsumerLoop::Next::package);
    EXPECT_EQ(package.events.size(), size);
    run.loop().complete(package);
  }
  EXPECT_EQ(run.ledger(), (Ledger{.received = kEvents, .delivered = kEvents}));
}

TEST(LiveRun, WhatTheFilterInFrontDropsIsFilteredAndNothingElse) {
  test::ScriptedScheme scheme(
      [](const Backlog& backlog) { return Decision::take(backlog.count, 0.25); });
  RunConfig config = kWhole;
  config.front_filter = [](EventSpan events, Event* out) {
    Event* const end = std::copy_if(events.begin(), events.end(), out,
                                    [](const Event& event) { return event.p == 0; });
    return static_cast<std::size_t>(end - out);
  };
  LiveRun run(scheme, config);
  run.push(test::evenly_spaced(1000, 10));  // every second one
  deliver_all(run);
  const Ledger ledger = run.ledger();
  EXPECT_EQ(ledger.filtered, 500u);
  EXPECT_GT(ledger.discarded, 100u);
  EXPECT_EQ(ledger.discarded + ledger.delivered, 500u);
  run.push(test::Events(10, {1, 0, 1, 10'000}));  // none
  deliver_all(run);
  EXPECT_EQ(run.ledger().filtered, 510u);
  EXPECT_EQ(run.ledger().discarded, ledger.discarded);
  EXPECT_EQ(run.ledger().pending, 0u);
}

TEST(LiveRun, EveryTermIsCountedOnItsOwnInTheEnd) {
  Greedy scheme;
  LiveRun run(scheme, kWhole);
  run.push(test::evenly_spaced(1000, 10), {});
  deliver_all(run);
  run.push(test::evenly_spaced(500, 10, 100'000), {});
  run.close();
  run.finish();
  EXPECT_EQ(run.ledger(), (Ledger{.received = 1500, .delivered = 1000, .pending = 500}));
  const std::int64_t elapsed_ns = run.elapsed_ns();
  EXPECT_GT(elapsed_ns, 0);
  EXPECT_EQ(run.elapsed_ns(), elapsed_ns);
}

TEST(LiveRun, TheBoundOfACopyIsConfigured) {
  test::ScriptedScheme scheme(
      [](const Backlog& backlog) { return Decision::take(backlog.count, 1 - 1e-9); });
  RunConfig config = kWhole;
  config.max_copied = 300;
  LiveRun run(scheme, config);
  run.push(test::evenly_spaced(500, 0), {});
  for (const std::size_t size : {300u, 200u}) {
    Package package;
    ASSERT_EQ(run.loop().next(package, 0ns), ConsumerLoop::Next::package);
    EXPECT_EQ(package.events.size(), size);
    run.loop().complete(package);
  }
}

// Lost at the door, dropped from a full ring, thinned there or stale: alone and in any mixture.
TEST(LiveRun, TheGapIsThatOfTheEventsBetweenDeliveredOnes) {
  for (const WhenFull when_full : {WhenFull::thin, WhenFull::newest, WhenFull::oldest}) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      const CounterRandom random(seed + 77);
      std::uint64_t draws = 0;
      const auto below = [&](std::size_t end) { return random(draws++) % end; };
      test::ScriptedScheme scheme([&](const Backlog& backlog) {
        const double keep = below(2) == 0 ? 1.0 : static_cast<double>(below(10)) / 10;
        Decision decision = Decision::take(1 + below(backlog.count), keep);
        if (seed % 3 == 0 && below(3) == 0) decision.stale = below(backlog.count);
        return decision;
      });
      RunConfig config = kWhole;
      config.capacity = 256;
      config.when_full = when_full;
      LiveRun run(scheme, config);
      test::Events delivered;
      const auto deliver = [&](std::size_t packages) {
        Package package;
        for (; packages > 0; --packages) {
          if (run.loop().next(package, 0ns) != ConsumerLoop::Next::package) return;
          delivered.insert(delivered.end(), package.events.begin(), package.events.end());
          run.loop().complete(package);
        }
      };
      const test::Events events = test::random_stream(seed, 4000);
      std::int64_t so_far_us = 0;
      for (EventSpan rest = events; !rest.empty();) {
        const std::size_t count = std::min<std::size_t>(rest.size(), 1 + below(500));
        run.push(rest.first(count));
        rest = rest.subspan(count);
        deliver(below(4));
        EXPECT_GE(run.gap_us(), so_far_us);
        so_far_us = run.gap_us();
      }
      run.close();
      deliver(events.size());
      run.finish();
      ASSERT_EQ(run.ledger().pending, 0u);
      ASSERT_EQ(run.gap_us(), test::gap_us(events, delivered))
          << "rule " << static_cast<int>(when_full) << ", seed " << seed;
    }
  }
}

TEST(LiveRun, WithoutALogTheTotalsAreThere) {
  Greedy scheme;
  RunConfig config = kWhole;
  config.log_rows = 0;
  LiveRun run(scheme, config);
  run.push(test::evenly_spaced(50, 0), {});
  deliver_all(run);
  EXPECT_EQ(run.telemetry().log.totals().size, 50u);
  EXPECT_EQ(run.telemetry().log.first(), run.telemetry().log.size());
}

TEST(LiveRun, AllocatesNothingAfterConstruction) {
  Greedy scheme;
  LiveRun run(scheme, kWhole);
  const test::Events events = test::evenly_spaced(50, 0, 1000);
  const std::size_t before = test::allocations();
  for (std::size_t i = 0; i < 2 * RunConfig{}.log_rows; ++i) {
    run.push(events, {});
    deliver_all(run);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(run.telemetry().log.totals().count, 2 * RunConfig{}.log_rows);
}

}  // namespace
}  // namespace asap::live_run_test
