// In real time, on a machine that may take the processor away from a thread for a second: what is
// exact here never depends on how soon a thread has its turn. Deadline drops what is too old, so
// tests that count what is delivered give it an hour.
#include "asap/runner/pipeline.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "asap/runner/replay.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "buffer/event_buffer.hpp"
#include "core/random.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"
#include "support/gap.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::pipeline_test {
namespace {

using Next = Pipeline::Next;
using test::at_times;
using test::evenly_spaced;
using test::Events;
using test::number_of;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

const RunConfig kWhole{.execution = Execution::whole};
constexpr auto kLong = std::chrono::nanoseconds(120s);  // a test that waits so long has failed
const RunConfig kPatient{.latency = 1h, .capacity = std::size_t{1} << 20};

// Waits for ever, unless something is due.
test::ScriptedScheme::Rule only_when_due() {
  return [](const Backlog& backlog) {
    return backlog.due ? Decision::take(backlog.count) : Decision::wait_for(1'000'000);
  };
}

// Pushes chunks with stamps that go on, until the pipeline refuses; counts what it has pushed.
struct Camera {
  explicit Camera(Pipeline& pipeline, std::size_t chunk, std::uint64_t max = ~std::uint64_t{0})
      : thread([this, &pipeline, chunk, max] {
          Events events = evenly_spaced(chunk, 0);
          for (std::int64_t t = 0; pushed < max && pipeline.push(events); ++t) {
            pushed += chunk;
            for (Event& event : events) event.t = t + 1;
          }
        }) {}

  std::atomic<std::uint64_t> pushed{0};
  std::jthread thread;
};

// Windows of what happened between two looks, as a monitor forms them.
TEST(Pipeline, ALookIsOfOneMoment) {
  FixedSize singly({.size = 1});
  Pipeline pipeline(singly, {.latency = 1h, .capacity = 10'000, .execution = Execution::whole},
                    [](EventSpan) {});
  Camera camera(pipeline, 100);
  PipelineStats before = pipeline.stats();
  for (int look = 0; look < 20'000 && !HasFailure(); ++look) {
    const PipelineStats now = pipeline.stats();
    const LatencyHistogram window = now.latency.since(before.latency);
    EXPECT_EQ(now.latency.count(), now.ledger.delivered) << look;
    EXPECT_EQ(now.packages.size, now.ledger.delivered) << look;
    EXPECT_EQ(window.count(), (now.ledger - before.ledger).delivered) << look;
    EXPECT_LE(window.within_bound(), window.count()) << look;
    before = now;
  }
  pipeline.stop(false);
  pipeline.join();
  EXPECT_GT(before.ledger.delivered, 0u);
}

TEST(Pipeline, FlushWaitsForNothing) {
  test::ScriptedScheme scheme(only_when_due());
  Pipeline pipeline(scheme, {.latency = 1000s, .execution = Execution::whole});
  pipeline.push(evenly_spaced(100, 1));
  Package package;
  EXPECT_EQ(pipeline.next(package, 5ms), Next::idle);
  std::jthread other([&] {
    std::this_thread::sleep_for(5ms);
    pipeline.flush();
  });
  const auto asked = Steady::now();
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  EXPECT_LT(Steady::now() - asked, kLong / 2) << "the flush wakes who sleeps";
  EXPECT_EQ(package.events.size(), 100u);
  pipeline.push(at_times({1000}));
  EXPECT_EQ(pipeline.next(package, 5ms), Next::idle) << "what came after the flush waits";
}

TEST(Pipeline, StopDrains) {
  FixedSize scheme({.size = 10});
  Pipeline pipeline(scheme, kWhole);
  pipeline.push(evenly_spaced(95, 1));
  pipeline.stop();
  std::size_t delivered = 0;
  Package package;
  while (pipeline.next(package, kLong) == Next::package) delivered += package.events.size();
  EXPECT_EQ(delivered, 95u);
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 95, .delivered = 95}));
}

TEST(Pipeline, StopWithoutDrainingEndsAfterThePackageInWork) {
  FixedSize scheme({.size = 10});
  Pipeline pipeline(scheme, kWhole);
  pipeline.push(evenly_spaced(95, 1));
  Package package;
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  pipeline.stop();
  pipeline.stop(false);
  EXPECT_EQ(pipeline.next(package, kLong), Next::ended);
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 95, .delivered = 10, .pending = 85}));
}

TEST(Pipeline, APackageGivenUpStaysPending) {
  FixedSize scheme({.size = 10});
  Pipeline pipeline(scheme, kWhole);
  pipeline.push(evenly_spaced(95, 1));
  Package package;
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  pipeline.abandon();
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 95, .pending = 95}));
  EXPECT_EQ(pipeline.next(package, kLong), Next::ended);
}

TEST(Pipeline, APushAfterStopIsRefusedAndNotCounted) {
  Greedy scheme;
  Pipeline pipeline(scheme, kWhole);
  EXPECT_TRUE(pipeline.push(at_times({1})));
  pipeline.stop();
  EXPECT_FALSE(pipeline.push(at_times({2})));
  EXPECT_EQ(pipeline.ledger().received, 1u);
}

TEST(Pipeline, StopsFromInsideTheAlgorithm) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  pipeline.push(evenly_spaced(10, 1));
  int calls = 0;
  pipeline.run([&](EventSpan) {
    ++calls;
    pipeline.stop();
  });
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 10, .delivered = 10}));
}

TEST(Pipeline, AnExceptionComesOutUnchangedAndStops) {
  struct Trouble {
    int code;
  };
  FixedSize scheme({.size = 10});
  Pipeline pipeline(scheme);
  pipeline.push(evenly_spaced(30, 1));
  int calls = 0;
  const auto work = [&](EventSpan) {
    if (++calls == 2) throw Trouble{7};
  };
  int code = 0;
  try {
    pipeline.run(work);
  } catch (const Trouble& trouble) {
    code = trouble.code;
  }
  EXPECT_EQ(code, 7);
  EXPECT_FALSE(pipeline.push(at_times({1000})));
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 30, .delivered = 10, .pending = 20}));
  pipeline.start();
  EXPECT_EQ(pipeline.ledger(), Ledger{});
  pipeline.push(evenly_spaced(10, 1));
  pipeline.stop();
  pipeline.run(work);
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 10, .delivered = 10}));
}

TEST(Pipeline, ANewRunTakesTheMemoryOfTheOneBefore) {
  Greedy scheme;
  Pipeline pipeline(scheme, {.capacity = 1000});
  const Events events = evenly_spaced(1500, 1);
  const auto run = [&] {
    pipeline.push(events);
    pipeline.begin_epoch(0);
    pipeline.stop();
    pipeline.run([](const Package& package) { EXPECT_EQ(package.index, 0u); });
    return pipeline.stats();
  };
  PipelineStats before = run();
  const RunLog& log = pipeline.log();
  EXPECT_EQ(log.size(), before.packages.count);
  EXPECT_NE(pipeline.clock_offset_us(), 0);
  const std::size_t allocated = test::allocations();
  pipeline.start();
  EXPECT_EQ(test::allocations(), allocated);
  EXPECT_EQ(log.size(), 0u) << "the same log";
  EXPECT_EQ(pipeline.clock_offset_us(), 0);

  const PipelineStats now = run();
  EXPECT_EQ(before.run, 1u);
  EXPECT_EQ(now.run, 2u);
  EXPECT_GT(now.begun, before.begun);
  EXPECT_EQ(now.ledger, before.ledger);
  EXPECT_EQ(now.rejected, before.rejected);
  EXPECT_EQ(now.clock_resets, before.clock_resets);
  EXPECT_EQ(now.latency.count(), before.latency.count());
  EXPECT_EQ(now.packages.size, before.packages.size);
  EXPECT_EQ(now.gap_us, before.gap_us);
  EXPECT_EQ(now.max_waiting, before.max_waiting);
}

TEST(Pipeline, ANewRunHasTheFilterInFrontAsItWasGiven) {
  Greedy scheme;
  RunConfig config{.capacity = 1000};
  config.front_filter = [first = true](EventSpan events, std::span<Event> out) mutable {
    std::ranges::copy(events, out.begin());
    return std::exchange(first, false) ? events.size() : 0;
  };
  Pipeline pipeline(scheme, config);
  for (int run = 0; run < 2; ++run) {
    pipeline.push(evenly_spaced(10, 1));
    pipeline.stop();
    pipeline.run([](EventSpan) {});
    EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 10, .delivered = 10}));
    pipeline.start();
  }
}

// Looked at by the producer between its pushes, also while another thread begins a new run.
TEST(Pipeline, TheClockOffsetMayBeReadAcrossRuns) {
  Pipeline pipeline({.latency = 5ms, .capacity = 4096, .log_rows = 0}, [](EventSpan) {});
  std::jthread producer([&](const std::stop_token& done) {
    Events event = at_times({0});
    for (; !done.stop_requested(); ++event[0].t) {
      pipeline.push(event);
      EXPECT_EQ(pipeline.clock_offset_us(), 0);
    }
  });
  for (int run = 0; run < 100; ++run) {
    pipeline.stop();
    pipeline.start();
  }
}

TEST(Pipeline, RefusesToRunNothing) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  EXPECT_EQ(test::error_of([&] { pipeline.run({}); }).rfind("algorithm = none", 0), 0u);
  EXPECT_TRUE(pipeline.is_open());
}

TEST(Pipeline, StartWhileOpenChangesNothing) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  pipeline.push(at_times({1}));
  pipeline.start();
  EXPECT_EQ(pipeline.ledger().received, 1u);
}

TEST(Pipeline, AStartThatFailsLeavesTheRunBefore) {
  struct Stubborn final : Scheme {
    std::int64_t bound_ns = 1'000'000;
    Decision decide(const Backlog& backlog) noexcept override {
      return Decision::take(backlog.count);
    }
    std::int64_t latency_bound_ns() const noexcept override { return bound_ns; }
    std::string_view name() const noexcept override { return "stubborn"; }
  } scheme;
  Pipeline pipeline(scheme, {.latency = 1000us});
  pipeline.push(at_times({1}));
  pipeline.abandon();
  scheme.bound_ns = 2'000'000;
  EXPECT_THROW(pipeline.start(), std::invalid_argument);
  EXPECT_FALSE(pipeline.is_open());
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 1, .pending = 1}));
  scheme.bound_ns = 1'000'000;
  pipeline.start();
  EXPECT_TRUE(pipeline.push(at_times({1})));
}

TEST(Pipeline, HasOneConsumerAtATime) {
  Greedy scheme;
  Pipeline pipeline(scheme, kWhole);
  pipeline.push(at_times({1}));
  pipeline.run([&](EventSpan) {
    Package package;
    EXPECT_THROW(pipeline.next(package, 0ns), std::logic_error);
    EXPECT_THROW(pipeline.start(), std::logic_error);
    pipeline.stop();
  });
  Package package;
  Pipeline anytime(scheme, {.execution = Execution::anytime});
  EXPECT_THROW(anytime.next(package, 0ns), std::logic_error);
}

TEST(Pipeline, AConsumerThatWaitsIsNotThrownOutByAnother) {
  Greedy scheme;
  Pipeline pipeline(scheme, kWhole);
  Package package;
  const auto other = [&] {
    Package none;
    EXPECT_THROW(pipeline.next(none, 0ns), std::logic_error);
    pipeline.push(at_times({1}));
  };
  EXPECT_EQ(pipeline.next(package, kLong, other), Next::package);
}

TEST(Pipeline, HasASchemeOfItsOwnWhileItRuns) {
  Greedy scheme;
  Package package;
  Pipeline one(scheme, kWhole);
  Pipeline early(scheme, kWhole);
  Replay replay(scheme);
  EXPECT_EQ(one.next(package, 0ns), Next::idle);
  EXPECT_THROW(early.next(package, 0ns), std::logic_error);
  EXPECT_THROW(Pipeline(scheme, kWhole), std::logic_error);
  EXPECT_THROW(Pipeline(scheme, kPatient, [](EventSpan) {}), std::logic_error);
  EXPECT_THROW(Replay{scheme}, std::logic_error);
  SpanSource nothing({});
  EXPECT_THROW(replay.run(nothing, [](EventSpan) {}), std::logic_error);
  Greedy another;
  Pipeline third(another, kWhole);
  EXPECT_EQ(third.next(package, 0ns), Next::idle);
  one.abandon();
  {
    const Pipeline other(scheme, kPatient, [](EventSpan) {});
    EXPECT_EQ(one.next(package, 0ns), Next::ended);
    EXPECT_THROW(one.start(), std::logic_error);
    EXPECT_FALSE(one.is_open());
  }
  one.start();
  EXPECT_EQ(one.next(package, 0ns), Next::idle);
}

TEST(Pipeline, GoesAwayOnceAnotherThreadHasLeftRun) {
  Greedy scheme;
  std::atomic<bool> is_inside = false;
  std::atomic<bool> is_done = false;
  auto pipeline = std::make_unique<Pipeline>(scheme, kWhole);
  const std::jthread consumer([&, used = pipeline.get()] {
    used->run([&](EventSpan) {
      is_inside = true;
      is_inside.notify_all();
      std::this_thread::sleep_for(20ms);
      is_done = true;
    });
  });
  pipeline->push(at_times({1}));
  is_inside.wait(false);
  pipeline.reset();
  EXPECT_TRUE(is_done);
}

TEST(Pipeline, RunCompletesThePackageOfNext) {
  FixedSize scheme({.size = 10});
  Pipeline pipeline(scheme, kWhole);
  pipeline.push(evenly_spaced(30, 1));
  Package package;
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  pipeline.stop();
  Events delivered;
  pipeline.run(
      [&](EventSpan events) { delivered.insert(delivered.end(), events.begin(), events.end()); });
  ASSERT_EQ(delivered.size(), 20u);
  EXPECT_EQ(number_of(delivered.front()), 10u) << "none twice";
  pipeline.complete();
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 30, .delivered = 30}));
}

TEST(Pipeline, CountsWhatTheDriverReports) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  pipeline.upstream_lost(1);
  pipeline.upstream_lost(2, 40);
  EXPECT_EQ(pipeline.stats().upstream_marks, 3u);
  EXPECT_EQ(pipeline.stats().upstream_packets, 40u);
  EXPECT_EQ(pipeline.ledger(), Ledger{});
  pipeline.stop();
  pipeline.start();
  EXPECT_EQ(pipeline.stats().upstream_marks, 0u);
  EXPECT_EQ(pipeline.stats().upstream_packets, 0u);
}

TEST(Pipeline, ItsTimeRunsFromTheFirstEventToTheEnd) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  pipeline.stop();
  EXPECT_EQ(pipeline.stats().elapsed_ns, 0) << "nothing came";
  pipeline.start();
  pipeline.push(at_times({1}), Steady::now() - 1s);
  pipeline.stop();
  const std::int64_t elapsed_ns = pipeline.stats().elapsed_ns;
  EXPECT_GE(elapsed_ns, 1'000'000'000);
  std::this_thread::sleep_for(1ms);
  EXPECT_EQ(pipeline.stats().elapsed_ns, elapsed_ns);
}

// ---- the way of an event

void deliver_all(Pipeline& run) {
  Package package;
  while (run.next(package, 0ns) == Next::package) {
  }
}

TEST(Pipeline, AShorterBoundTellsArrivalsApartThatALongerOneTakesTogether) {
  Greedy scheme;
  RunConfig config = kWhole;
  config.latency = 1h;
  Pipeline run(scheme, config);
  run.set_latency(1ms);
  const auto arrival = Steady::now() - 1s;
  run.push(at_times({1}), arrival);
  run.push(at_times({2}), arrival + 500ms);
  deliver_all(run);
  const LatencyHistogram& latency = run.stats().latency;
  EXPECT_NEAR(latency.mean_ns(), static_cast<double>(latency.max_ns()) - 250e6, 1e4);
}

TEST(Pipeline, SaysHowManyHaveWaitedAtMost) {
  Greedy scheme;
  Pipeline run(scheme, kWhole);
  run.push(test::evenly_spaced(100, 1));
  deliver_all(run);
  run.push(at_times({1'000'000}));
  EXPECT_EQ(run.stats().max_waiting, 100u);
}

TEST(Pipeline, WhatTheFilterInFrontDropsIsFilteredAndNothingElse) {
  test::ScriptedScheme scheme(
      [](const Backlog& backlog) { return Decision::take(backlog.count, 0.25); });
  RunConfig config = kWhole;
  config.front_filter = [](EventSpan events, std::span<Event> out) {
    const auto end = std::copy_if(events.begin(), events.end(), out.begin(),
                                  [](const Event& event) { return event.p == 0; });
    return static_cast<std::size_t>(end - out.begin());
  };
  Pipeline run(scheme, config);
  run.push(test::evenly_spaced(1000, 10));  // every second one
  deliver_all(run);
  const Ledger ledger = run.ledger();
  EXPECT_EQ(ledger.filtered, 500u);
  EXPECT_NEAR(static_cast<double>(ledger.delivered), 250, 50) << "the share is of all that came";
  EXPECT_EQ(ledger.discarded + ledger.delivered, 500u);
  run.push(test::Events(10, {1, 0, 1, 10'000}));  // none
  deliver_all(run);
  EXPECT_EQ(run.ledger().filtered, 510u);
  EXPECT_EQ(run.ledger().discarded, ledger.discarded);
  EXPECT_EQ(run.ledger().pending, 0u);
}

TEST(Pipeline, AFilterInFrontThatSaysMoreThanThereIsIsNotBelieved) {
  Greedy scheme;
  RunConfig config = kWhole;
  config.front_filter = [](EventSpan events, std::span<Event> out) {
    std::ranges::copy(events, out.begin());
    return events.size() + 5;
  };
  Pipeline run(scheme, config);
  run.push(test::evenly_spaced(100, 10));
  deliver_all(run);
  EXPECT_EQ(run.ledger(), (Ledger{.received = 100, .delivered = 100}));
}

TEST(Pipeline, TheBoundOfACopyIsConfigured) {
  test::ScriptedScheme scheme(
      [](const Backlog& backlog) { return Decision::take(backlog.count, 1 - 1e-9); });
  RunConfig config = kWhole;
  config.max_copied = 300;
  Pipeline run(scheme, config);
  run.push(test::evenly_spaced(500, 0), {});
  for (const std::size_t size : {300u, 200u}) {
    Package package;
    ASSERT_EQ(run.next(package, 0ns), Next::package);
    EXPECT_EQ(package.events.size(), size);
    run.complete();
  }
}

// Lost at the door, dropped from a full ring, thinned there or stale: alone and in any mixture.
TEST(Pipeline, TheGapIsThatOfTheEventsBetweenDeliveredOnes) {
  for (const WhenFull when_full : {WhenFull::thin, WhenFull::keep_oldest, WhenFull::keep_newest}) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      const CounterRandom random(seed + 77);
      std::uint64_t draws = 0;
      const auto below = [&](std::size_t end) { return random(draws++) % end; };
      test::ScriptedScheme scheme([&](const Backlog& backlog) {
        const double gamma = below(2) == 0 ? 1.0 : static_cast<double>(below(10)) / 10;
        Decision decision = Decision::take(1 + below(backlog.count), gamma);
        if (seed % 3 == 0 && below(3) == 0) decision.stale = below(backlog.count);
        return decision;
      });
      RunConfig config = kWhole;
      config.capacity = 256;
      config.when_full = when_full;
      Pipeline run(scheme, config);
      test::Events delivered;
      const auto deliver = [&](std::size_t packages) {
        Package package;
        for (; packages > 0; --packages) {
          if (run.next(package, 0ns) != Next::package) return;
          delivered.insert(delivered.end(), package.events.begin(), package.events.end());
          run.complete();
        }
      };
      const test::Events events = test::random_stream(seed, 4000);
      std::int64_t so_far_us = 0;
      for (EventSpan rest = events; !rest.empty();) {
        const std::size_t count = std::min<std::size_t>(rest.size(), 1 + below(500));
        run.push(rest.first(count));
        rest = rest.subspan(count);
        deliver(below(4));
        EXPECT_GE(run.stats().gap_us, so_far_us);
        so_far_us = run.stats().gap_us;
      }
      run.stop();
      deliver(events.size());
      ASSERT_EQ(run.ledger().pending, 0u);
      ASSERT_EQ(run.stats().gap_us, test::gap_us(events, delivered))
          << "rule " << static_cast<int>(when_full) << ", seed " << seed;
    }
  }
}

TEST(Pipeline, ItsLogIsBounded) {
  Greedy scheme;
  const std::size_t wraps = RunLog::kAllRows / sizeof(PackageRecord) + 2;
  for (const std::size_t rows : {RunLog::kAllRows, RunLog::kMaxRows + 1, wraps}) {
    const std::string said = make_pipeline(scheme, {.log_rows = rows}).message();
    EXPECT_TRUE(said.starts_with("log_rows = " + std::to_string(rows))) << said;
    EXPECT_GE(memory_bytes({.log_rows = rows}), RunLog::kMaxRows) << "a sum that wraps";
  }
}

TEST(Pipeline, WithoutALogTheTotalsAreThere) {
  Greedy scheme;
  RunConfig config = kWhole;
  config.log_rows = 0;
  Pipeline run(scheme, config);
  run.push(test::evenly_spaced(50, 0), {});
  deliver_all(run);
  EXPECT_EQ(run.log().totals().size, 50u);
  EXPECT_EQ(run.log().first(), run.log().size());
}

// ---- under pressure: what gives way, and what may change meanwhile

RunConfig whole(std::size_t capacity, WhenFull when_full) {
  return {.capacity = capacity, .execution = Execution::whole, .when_full = when_full};
}

TEST(PipelineBlock, AFileIsNeitherThinnedNorLost) {
  const Events events = evenly_spaced(200'000, 0);
  FixedSize scheme({.size = 10});
  Pipeline pipeline(scheme, whole(64, WhenFull::block));
  std::jthread producer([&] {
    EXPECT_TRUE(pipeline.push(events));
    pipeline.stop();
  });
  std::uint64_t next = 0;
  Package package;
  while (pipeline.next(package, kLong) == Next::package) {
    for (const Event& event : package.events) ASSERT_EQ(number_of(event), next++);
  }
  producer.join();
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 200'000, .delivered = 200'000}));
}

TEST(PipelineBlock, SaysHowManyWaitWhileThePushWaits) {
  Greedy scheme;
  Pipeline pipeline(scheme, whole(64, WhenFull::block));
  const auto poll = [&] {
    EXPECT_EQ(pipeline.stats().max_waiting, 64u);
    throw std::runtime_error("interrupted");
  };
  EXPECT_THROW(pipeline.push(evenly_spaced(100, 1), {}, poll), std::runtime_error);
}

TEST(PipelineBlock, StopFreesTheProducer) {
  Greedy scheme;
  Pipeline pipeline(scheme, whole(64, WhenFull::block));
  std::jthread producer([&] { EXPECT_TRUE(pipeline.push(evenly_spaced(1000, 1))); });
  while (pipeline.ledger().pending < 64) std::this_thread::yield();
  pipeline.stop(false);
  producer.join();
  Package package;
  EXPECT_EQ(pipeline.next(package, kLong), Next::ended);
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 1000, .overflow = 936, .pending = 64}));
}

TEST(PipelineBlock, WhatHasNotGotInWhenItsPollThrowsIsOverflow) {
  for (const bool repaired : {false, true}) {
    Greedy scheme;
    Pipeline pipeline(scheme, whole(64, WhenFull::block));
    Events events = evenly_spaced(1000, 1);
    if (repaired) events[300].p = 7;  // the validator passes such a push on in pieces
    EXPECT_THROW(pipeline.push(events, {}, [] { throw std::runtime_error("interrupted"); }),
                 std::runtime_error);
    EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 1000, .overflow = 936, .pending = 64}));
  }
}

TEST(PipelineBlock, ItsPollMayStop) {
  Greedy scheme;
  Pipeline pipeline(scheme, whole(64, WhenFull::block));
  EXPECT_TRUE(pipeline.push(evenly_spaced(1000, 1), {}, [&] { pipeline.stop(); }));
  EXPECT_FALSE(pipeline.push(at_times({2000})));
  std::size_t delivered = 0;
  Package package;
  while (pipeline.next(package, kLong) == Next::package) delivered += package.events.size();
  EXPECT_EQ(delivered, 64u) << "what has got in is drained";
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 1000, .overflow = 936, .delivered = 64}));
  pipeline.start();
  EXPECT_TRUE(pipeline.push(at_times({1})));
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 1, .pending = 1}));
}

TEST(PipelineBlock, ItsPollMayLookWhileAnotherThreadStops) {
  Greedy scheme;
  Pipeline pipeline(scheme, whole(64, WhenFull::block));
  std::atomic<bool> polls{false};
  std::jthread other([&] {
    polls.wait(false);
    pipeline.stop();
    EXPECT_EQ(pipeline.ledger().pending, 64u) << "the push is inside: not the end";
    polls = false;
    polls.notify_one();
  });
  EXPECT_TRUE(pipeline.push(evenly_spaced(1000, 1), {}, [&] {
    polls = true;
    polls.notify_one();
    polls.wait(true);
    EXPECT_TRUE(pipeline.stats().ledger.balanced());
  }));
  EXPECT_EQ(pipeline.ledger().received, 1000u);
}

TEST(PipelineBlock, ANewRunWaitsForThePushOfTheOneBefore) {
  Greedy scheme;
  Pipeline pipeline(scheme, whole(64, WhenFull::block));
  std::atomic<bool> left{false};
  std::jthread starter;
  EXPECT_TRUE(pipeline.push(evenly_spaced(1000, 1), {}, [&] {
    pipeline.abandon();
    starter = std::jthread([&] {
      pipeline.start();
      EXPECT_TRUE(left);
    });
    std::this_thread::sleep_for(20ms);
    left = true;
  }));
  starter.join();
  EXPECT_EQ(pipeline.ledger(), Ledger{});
}

TEST(Pipeline, SaysThatItsConsumerHasStalled) {
  Greedy scheme;
  RunConfig config = whole(1000, WhenFull::thin);
  config.latency = 1000us;
  Pipeline pipeline(scheme, config);
  EXPECT_FALSE(pipeline.stats().stalled) << "there is nothing to do";
  pipeline.push(at_times({1}));
  const auto until = std::chrono::steady_clock::now() + kLong;
  const auto becomes = [&](bool stalled) {
    while (pipeline.stats().stalled != stalled && std::chrono::steady_clock::now() < until) {
      std::this_thread::yield();
    }
    return pipeline.stats().stalled == stalled;
  };
  EXPECT_TRUE(becomes(true)) << "nobody has come";
  Package package;
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  EXPECT_TRUE(becomes(true)) << "it does not come back";
  std::jthread consumer([&] { EXPECT_EQ(pipeline.next(package, kLong), Next::ended); });
  EXPECT_TRUE(becomes(false)) << "it sleeps, and that is right";
  pipeline.stop();
}

TEST(Pipeline, TakesAnotherLatencyBoundWhileItRuns) {
  Deadline scheme({.latency = 3'600'000ms});
  RunConfig config = whole(1000, WhenFull::thin);
  Pipeline pipeline(scheme, config);
  // Alone, an event would wait for others as long as the bound allows.
  test::ScriptedScheme patient([](const Backlog& backlog) {
    return backlog.due ? Decision::take(backlog.count) : Decision::wait_for(1000);
  });
  Pipeline waiting(patient, {.latency = 1h, .execution = Execution::whole});
  waiting.push(at_times({1}));
  Package package;
  ASSERT_EQ(waiting.next(package, 0ns), Next::idle);
  std::jthread changes([&] { waiting.set_latency(1ms); });
  ASSERT_EQ(waiting.next(package, kLong), Next::package) << "due by the new bound";
  waiting.complete();
  EXPECT_EQ(waiting.stats().latency_bound_ns, 1'000'000);
  EXPECT_EQ(waiting.stats().latency.bound_ns(), 1'000'000);

  pipeline.set_latency(20ms);
  EXPECT_EQ(pipeline.stats().latency_bound_ns, 20'000'000);
  pipeline.stop();
  pipeline.start();
  EXPECT_EQ(scheme.latency_bound_ns(), 20'000'000) << "later runs have it, and the scheme too";
  EXPECT_EQ(scheme.parameters()[0].second, SchemeParameter(20.0));
  EXPECT_EQ(test::error_of([&] { pipeline.set_latency(1us); }).rfind("latency = 0.001 ms", 0), 0u);
}

TEST(Pipeline, ASensorThatBeginsAnewMakesWhatWaitsDue) {
  test::ScriptedScheme patient([](const Backlog& backlog) {
    return backlog.due ? Decision::take(backlog.count) : Decision::wait_for(1000);
  });
  Pipeline pipeline(patient, {.latency = 1h, .execution = Execution::whole});
  pipeline.push(at_times({50'000'000, 50'000'001}));
  Package package;
  ASSERT_EQ(pipeline.next(package, 0ns), Next::idle);
  pipeline.push(at_times(std::vector<std::int64_t>(Validator::kStays, 7)));  // fewer are stray
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  EXPECT_EQ(package.events.back().t, 50'000'002) << "time goes on";
  EXPECT_EQ(pipeline.stats().clock_resets, 1u);
}

TEST(Pipeline, AnEpochThatIsToldLosesNoEvent) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  pipeline.push(at_times({50'000, 50'100}));
  pipeline.begin_epoch(49'000);
  EXPECT_EQ(pipeline.clock_offset_us(), 1'101);
  pipeline.push(at_times({49'000, 49'005}));
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 4, .pending = 4}));
  EXPECT_EQ(pipeline.stats().clock_resets, 1u);
}

TEST(Pipeline, APushInAnEpochOfItsOwnIsOnePackage) {
  Pipeline pipeline({.latency = 10s}, [](const Package&) {});
  std::int64_t t = 1'000'000;
  const auto push = [&] {
    std::vector<std::int64_t> stamps;
    for (int i = 0; i < 2'000; ++i) stamps.push_back(t++);
    pipeline.push(at_times(stamps));
    while (pipeline.ledger().pending > 0) std::this_thread::sleep_for(1ms);
  };
  push();
  pipeline.begin_epoch(t = 0);
  for (int i = 0; i < 50; ++i) push();
  pipeline.stop();
  pipeline.join();
  // A few are cut where the consumer has not gone to sleep yet.
  EXPECT_LT(pipeline.stats().packages.count, 100u);
}

TEST(Pipeline, ReportsTheDelayOfTheTransport) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  const auto now = std::chrono::steady_clock::now();
  pipeline.push(at_times({1'000'000}), now - 500ms);
  pipeline.push(at_times({1'100'000}), now - 360ms);
  EXPECT_EQ(pipeline.stats().sensor_delay_ns, 40'000'000);
  pipeline.push(at_times({1'200'000}), now - 300ms);
  EXPECT_EQ(pipeline.stats().sensor_delay_ns, 0);
  EXPECT_EQ(pipeline.stats().sensor_delay_max_ns, 40'000'000);
  pipeline.push(at_times({100}), now);
  EXPECT_EQ(pipeline.stats().sensor_delay_ns, 0) << "a clock that begins anew is another clock";
}

// Clocks drift apart: what has been the least delay for long becomes the rule.
TEST(Pipeline, TheLeastDelayOfTheTransportIsRememberedForAWindow) {
  Greedy scheme;
  Pipeline pipeline(scheme);
  const auto begin = std::chrono::steady_clock::now() - 27s;
  const auto push = [&](std::int64_t stamp_ms, std::int64_t late_ms) {
    pipeline.push(at_times({1000 * stamp_ms}),
                  begin + std::chrono::milliseconds(stamp_ms + late_ms));
    return pipeline.stats().sensor_delay_ns;
  };
  push(0, 0);
  for (std::int64_t ms = 10; ms < 9'000; ms += 10) ASSERT_EQ(push(ms, 4), 4'000'000) << ms;
  push(20'000, 4);
  EXPECT_EQ(push(26'000, 4), 0);
}

// ---- with a thread of its own

TEST(PipelineWorker, DeliversUntilItIsStopped) {
  const Events events = evenly_spaced(100'000, 1);
  std::uint64_t next = 0;
  Pipeline pipeline{kPatient, [&](EventSpan part) {
                      for (const Event& event : part) EXPECT_EQ(number_of(event), next++);
                    }};
  for (std::size_t i = 0; i < events.size(); i += 1000) {
    EXPECT_TRUE(pipeline.push(EventSpan(events).subspan(i, 1000)));
  }
  pipeline.stop();
  pipeline.join();
  EXPECT_EQ(next, events.size());
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 100'000, .delivered = 100'000}));
  pipeline.join();  // again: nothing
}

TEST(PipelineWorker, JoinThrowsWhatTheAlgorithmThrew) {
  Pipeline pipeline{kPatient, [](EventSpan) { throw std::domain_error("of the algorithm"); }};
  EXPECT_FALSE(pipeline.stats().failed);
  pipeline.push(evenly_spaced(10, 1));
  EXPECT_THROW(pipeline.join(), std::domain_error);
  EXPECT_FALSE(pipeline.is_open());
  EXPECT_TRUE(pipeline.stats().failed);
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 10, .pending = 10}));
  pipeline.join();  // said once
  pipeline.start();
  EXPECT_FALSE(pipeline.stats().failed);
  pipeline.stop();
  pipeline.join();  // nor by the next run
}

TEST(PipelineWorker, IsWaitedForNoLongerThanAsked) {
  std::atomic<bool> hangs = true;
  Pipeline pipeline{kPatient, [&](EventSpan) {
                      hangs.wait(true);
                      throw std::domain_error("of the algorithm");
                    }};
  pipeline.push(evenly_spaced(10, 1));
  pipeline.stop();
  EXPECT_FALSE(pipeline.join_for(0ns));
  EXPECT_FALSE(pipeline.join_for(10ms));
  hangs = false;
  hangs.notify_all();
  EXPECT_THROW(pipeline.join_for(std::chrono::nanoseconds::max()), std::domain_error);
  EXPECT_TRUE(pipeline.join_for(0ns));
}

TEST(PipelineWorker, AnyThreadMayStartAndWait) {
  Pipeline pipeline{kPatient, [](EventSpan) {}};
  for (int round = 0; round < 300; ++round) {
    pipeline.stop();
    const std::jthread waits([&] { pipeline.join(); });
    {
      const std::jthread one([&] { pipeline.start(); });
      const std::jthread other([&] { pipeline.start(); });
    }
    ASSERT_TRUE(pipeline.push(evenly_spaced(10, 1)));
    pipeline.stop();
  }
}

TEST(PipelineWorker, StopsFromInsideAndCannotWaitForItself) {
  std::atomic<bool> refused = false;
  Pipeline* self = nullptr;
  Pipeline pipeline{kPatient, [&](EventSpan) {
                      self->stop();
                      try {
                        self->join();
                      } catch (const std::logic_error&) {
                        refused = true;
                      }
                    }};
  self = &pipeline;
  pipeline.push(evenly_spaced(10, 1));
  pipeline.join();
  EXPECT_TRUE(refused);
  EXPECT_EQ(pipeline.ledger().delivered, 10u);
}

TEST(PipelineWorker, GoesAwayInAnyState) {
  for (int events = 0; events < 40; ++events) {
    Pipeline pipeline{{.capacity = 16}, [](EventSpan) {}};
    for (int push = 0; push < events; ++push) pipeline.push(evenly_spaced(3, 1));
  }
}

// The seat is the worker's before its thread runs.
TEST(PipelineWorker, RefusesOtherConsumers) {
  for (int round = 0; round < 200; ++round) {
    std::atomic<std::uint64_t> delivered = 0;
    Pipeline pipeline{kPatient, [&](EventSpan part) { delivered += part.size(); }};
    Package package;
    EXPECT_THROW(pipeline.run([](EventSpan) {}), std::logic_error);
    EXPECT_THROW(pipeline.next(package, 0ns), std::logic_error);
    EXPECT_THROW(pipeline.complete(), std::logic_error);
    pipeline.push(evenly_spaced(10, 1));
    pipeline.stop();
    ASSERT_NO_THROW(pipeline.join());
    ASSERT_EQ(delivered, 10u);
    EXPECT_THROW(pipeline.next(package, 0ns), std::logic_error) << "start() may come";
  }
}

TEST(PipelineWorker, MayBeAbandonedWhileItBegins) {
  Pipeline pipeline{{.capacity = 16}, [](EventSpan) {}};
  std::jthread other([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) pipeline.abandon();
  });
  for (int round = 0; round < 500; ++round) {
    pipeline.push(evenly_spaced(3, 1));
    ASSERT_NO_THROW(pipeline.join());
    ASSERT_NO_THROW(pipeline.start());
  }
}

TEST(PipelineWorker, WorksUnderTheSchemeThatItIsGiven) {
  FixedSize scheme({.size = 10});
  std::uint64_t packages = 0;
  Pipeline pipeline{scheme, {.latency = 1h}, [&](EventSpan part) {
                      EXPECT_EQ(part.size(), 10u);
                      ++packages;
                    }};
  pipeline.push(evenly_spaced(100, 1));
  pipeline.stop();
  pipeline.join();
  EXPECT_EQ(packages, 10u);
  EXPECT_EQ(test::error_of([&] { Pipeline(scheme, {}, Consumer{}); }).rfind("algorithm", 0), 0u);
}

TEST(PipelineWorker, IsPreparedOnItsOwnThreadInEveryRun) {
  std::thread::id prepared;
  int preparations = 0;
  RunConfig config = kPatient;
  config.on_worker_start = [&] {
    prepared = std::this_thread::get_id();
    ++preparations;
  };
  Pipeline pipeline{config, [&](EventSpan) { EXPECT_EQ(std::this_thread::get_id(), prepared); }};
  for (int run = 1; run <= 3; ++run) {
    pipeline.push(evenly_spaced(10, 1));
    pipeline.stop();
    pipeline.join();
    EXPECT_EQ(preparations, run);
    EXPECT_EQ(pipeline.ledger().delivered, 10u);
    pipeline.start();
  }
}

TEST(PipelineWorker, WhatItsPreparationThrowsComesOutOfJoin) {
  RunConfig config = kPatient;
  config.on_worker_start = [] { throw std::domain_error("no such processor"); };
  Pipeline pipeline{config, [](EventSpan) {}};
  EXPECT_THROW(pipeline.join(), std::domain_error);
  EXPECT_FALSE(pipeline.is_open());
}

TEST(PipelineWorker, NeedsAnAlgorithm) {
  EXPECT_EQ(test::error_of([] { Pipeline({}, Consumer{}); }).rfind("algorithm", 0), 0u);
}

// ---- without exceptions ---------------------------------------------------------------------

TEST(MakePipeline, GivesOneThatWorks) {
  std::atomic<std::uint64_t> delivered = 0;
  const Result<Pipeline> pipeline =
      make_pipeline(kPatient, [&](EventSpan part) { delivered += part.size(); });
  ASSERT_TRUE(pipeline) << pipeline.message();
  pipeline->push(evenly_spaced(100, 1));
  pipeline->stop();
  pipeline->join();
  EXPECT_EQ(delivered, 100u);
}

TEST(MakePipeline, NamesTheFieldAsItsCallerWroteIt) {
  Deadline scheme;
  const std::string remedy = ": must be between 0.01 and 1e7 ms";
  EXPECT_EQ(make_pipeline(scheme, {.latency = -5us}).message(), "latency = -0.005 ms" + remedy);
  EXPECT_EQ(make_pipeline({.latency = -5us}, [](EventSpan) {}).message(),
            "latency = -0.005 ms" + remedy);
  EXPECT_EQ(test::error_of([] { Pipeline({.latency = -5us}, [](EventSpan) {}); }),
            "latency = -0.005 ms" + remedy);
  EXPECT_EQ(make_pipeline({}, Consumer{}).message(),
            "algorithm = none: give what the events are for");
}

TEST(MakePipeline, TellsThePartsOfWhatItRefuses) {
  const Error time = make_pipeline({.latency = -5us}, [](EventSpan) {}).error();
  EXPECT_EQ(time.field, "latency");
  EXPECT_EQ(time.value, "-0.005 ms");
  EXPECT_EQ(time.remedy, "must be between 0.01 and 1e7 ms");
  const Error number = make_pipeline({.validator = {.width = -1}}, [](EventSpan) {}).error();
  EXPECT_EQ(number.field, "width");
  EXPECT_EQ(number.value, "-1");
}

TEST(MakePipeline, RefusedItHasTakenNothing) {
  const std::string refused = "capacity = 1099511627776: needs ";
  const std::ptrdiff_t before = test::live_allocations();
  EXPECT_EQ(make_pipeline({.capacity = EventBuffer::kMaxCapacity}, [](EventSpan) {})
                .message()
                .substr(0, refused.size()),
            refused);
  EXPECT_EQ(test::live_allocations(), before);
}

TEST(MakePipeline, WhereverMemoryEndsItHasTakenNothing) {
  const RunConfig small{.capacity = 64, .max_copied = 64};
  EXPECT_GT(test::allocations_until_made([&] { return make_pipeline(small, [](EventSpan) {}); }),
            10);
  Greedy scheme;
  EXPECT_GT(test::allocations_until_made([&] { return make_pipeline(scheme, small); }), 10);
}

TEST(Pipeline, EndsInAForkedProcess) {
  auto pipeline = std::make_unique<Pipeline>(RunConfig{}, [](EventSpan) {});
  pipeline->push(at_times({0, 1}));
  const pid_t child = fork();
  if (child == 0) {
    int refused = 0;
    try {
      pipeline->join();
    } catch (const std::logic_error&) {
      refused = 1;
    }
    pipeline.reset();
    _exit(refused);
  }
  int status = 0;
  const auto until = Steady::now() + kLong;
  while (waitpid(child, &status, WNOHANG) == 0 && Steady::now() < until) {
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  kill(child, SIGKILL);
}

#if defined(__GLIBC__)
TEST(MakePipeline, SaysThatThereIsNoThread) {
  pthread_attr_t as_it_was;
  ASSERT_EQ(pthread_getattr_default_np(&as_it_was), 0);
  pthread_attr_t huge = as_it_was;
  ASSERT_EQ(pthread_attr_setstacksize(&huge, std::size_t{1} << 46), 0);
  ASSERT_EQ(pthread_setattr_default_np(&huge), 0);
  const std::ptrdiff_t before = test::live_allocations();
  const bool is_said = make_pipeline({}, [](EventSpan) {}).message().starts_with("the worker has ");
  EXPECT_EQ(test::live_allocations(), before);
  ASSERT_EQ(pthread_setattr_default_np(&as_it_was), 0);
  EXPECT_TRUE(is_said);
}
#endif

}  // namespace
}  // namespace asap::pipeline_test
