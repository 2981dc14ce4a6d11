// A pipeline under pressure: what gives way, what is said about it, and what may change meanwhile.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed_size.hpp"
#include "asap/schemes/greedy.hpp"
#include "support/errors.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap {
namespace {

using Next = Pipeline::Next;
using test::at_times;
using test::evenly_spaced;
using test::Events;
using test::number_of;
using namespace std::chrono_literals;

constexpr auto kLong = std::chrono::nanoseconds(20s);  // a test that waits so long has failed

RunConfig whole(std::size_t capacity, WhenFull when_full) {
  return {.capacity = capacity, .execution = Execution::whole, .when_full = when_full};
}

test::ScriptedScheme::Rule all_that_waits() {
  return [](const Backlog& backlog) { return Decision::take(backlog.count); };
}

TEST(PipelineThin, OverflowStaysZeroAndGammaSaysIt) {
  test::ScriptedScheme scheme(all_that_waits());
  Pipeline pipeline(scheme, whole(1000, WhenFull::thin));
  for (int push = 0; push < 150; ++push) {
    pipeline.push(evenly_spaced(10, 0, push), std::chrono::steady_clock::now());
    std::this_thread::sleep_for(10us);  // steps of the arrival table
  }
  Package package;
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  EXPECT_NEAR(package.gamma, 0.66, 0.02);
  pipeline.stop();
  EXPECT_EQ(pipeline.next(package, kLong), Next::ended);
  const PipelineStats stats = pipeline.stats();
  EXPECT_EQ(stats.ledger.received, 1500u);
  EXPECT_EQ(stats.ledger.overflow, 0u);
  EXPECT_EQ(stats.ledger.discarded, 1500 - stats.ledger.delivered);
  EXPECT_LT(stats.ledger.delivered, 1000u);
  EXPECT_GT(stats.ledger.delivered, 950u);
  EXPECT_TRUE(stats.ledger.balanced());
  EXPECT_EQ(stats.most_waiting, stats.ledger.delivered);
}

TEST(PipelineOldest, AFullRingLosesItsOlderHalf) {
  Greedy scheme;
  Pipeline pipeline(scheme, whole(100, WhenFull::oldest));
  pipeline.push(evenly_spaced(130, 1));
  Package package;
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  EXPECT_EQ(number_of(package.events.front()), 50u);
  EXPECT_EQ(package.events.size(), 50u);
  EXPECT_EQ(package.overflow_before, 80u) << "30 that did not fit, 50 that made room";
  pipeline.stop();
  EXPECT_EQ(pipeline.next(package, kLong), Next::ended);
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 130, .overflow = 80, .delivered = 50}));
}

TEST(PipelineOldest, ARingThatIsNotFullLosesNothing) {
  Greedy scheme;
  for (const std::size_t events : {std::size_t{99}, std::size_t{1}}) {
    Pipeline pipeline(scheme, whole(events == 1 ? 1 : 100, WhenFull::oldest));
    pipeline.push(evenly_spaced(events, 1));
    Package package;
    ASSERT_EQ(pipeline.next(package, kLong), Next::package);
    EXPECT_EQ(package.events.size(), events) << "nor one of a single slot";
  }
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

TEST(Pipeline, SaysThatItsConsumerHasStalled) {
  Greedy scheme;
  RunConfig config = whole(1000, WhenFull::thin);
  config.latency_us = 1000;
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
  Deadline scheme({.latency_ms = 3'600'000});
  RunConfig config = whole(1000, WhenFull::thin);
  Pipeline pipeline(scheme, config);
  // Alone, an event would wait for others as long as the bound allows.
  test::ScriptedScheme patient([](const Backlog& backlog) {
    return backlog.due ? Decision::take(backlog.count) : Decision::wait_for(1000);
  });
  Pipeline waiting(patient, {.latency_us = 3.6e9, .execution = Execution::whole});
  waiting.push(at_times({1}));
  Package package;
  ASSERT_EQ(waiting.next(package, 0ns), Next::idle);
  std::jthread changes([&] { waiting.set_latency(1000); });
  ASSERT_EQ(waiting.next(package, kLong), Next::package) << "due by the new bound";
  waiting.complete();
  EXPECT_EQ(waiting.stats().latency_bound_ns, 1'000'000);
  EXPECT_EQ(waiting.stats().latency.bound_ns(), 1'000'000);

  pipeline.set_latency(20'000);
  EXPECT_EQ(pipeline.stats().latency_bound_ns, 20'000'000);
  pipeline.stop();
  pipeline.start();
  EXPECT_EQ(scheme.latency_bound_ns(), 20'000'000) << "later runs have it, and the scheme too";
  EXPECT_EQ(scheme.parameters()[0].second, SchemeParameter(20.0));
  EXPECT_EQ(test::error_of([&] { pipeline.set_latency(1); }).rfind("latency_us = 1", 0), 0u);
}

TEST(Pipeline, ASensorThatBeginsAnewMakesWhatWaitsDue) {
  test::ScriptedScheme patient([](const Backlog& backlog) {
    return backlog.due ? Decision::take(backlog.count) : Decision::wait_for(1000);
  });
  Pipeline pipeline(patient, {.latency_us = 3.6e9, .execution = Execution::whole});
  pipeline.push(at_times({50'000'000, 50'000'001}));
  Package package;
  ASSERT_EQ(pipeline.next(package, 0ns), Next::idle);
  pipeline.push(at_times({7}));
  ASSERT_EQ(pipeline.next(package, kLong), Next::package);
  EXPECT_EQ(package.events.back().t, 50'000'002) << "time goes on";
  EXPECT_EQ(pipeline.stats().clock_resets, 1u);
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
}

}  // namespace
}  // namespace asap
