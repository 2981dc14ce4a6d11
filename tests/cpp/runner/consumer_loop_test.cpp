#include "runner/consumer_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <thread>
#include <vector>

#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "packager/event_times.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::consumer_loop_test {
namespace {

using Next = ConsumerLoop::Next;
using namespace std::chrono_literals;

struct Rig {
  explicit Rig(Scheme& scheme, std::int64_t bound_ns = 10'000'000)
      : telemetry(bound_ns), packager(buffer, ages, scheme, telemetry, {.seed = 0}) {
    packager.set_axis(TimeAxis(0, 1.0));
    clock.start(0);
  }

  void push(EventSpan events) {
    buffer.push(events);
    doorbell.announce(buffer.tail());
  }

  EventBuffer buffer{1024};
  AgeSlots ages{1'000'000};
  Telemetry telemetry;
  Packager packager;
  Doorbell doorbell;
  RunClock clock;
  ConsumerLoop loop{buffer, packager, telemetry, doorbell, clock};
};

TEST(ConsumerLoop, IsIdleWhenNothingComes) {
  FixedSize scheme;
  Rig rig(scheme);
  Package package;
  EXPECT_EQ(rig.loop.next(package, 0ns), Next::idle);
  EXPECT_EQ(rig.loop.next(package, 5ms), Next::idle);
}

TEST(ConsumerLoop, WaitsForEver) {
  FixedSize scheme;
  Rig rig(scheme);
  std::jthread other([&] { rig.loop.abandon(); });
  Package package;
  EXPECT_EQ(rig.loop.next(package, std::chrono::nanoseconds::max()), Next::ended);
}

TEST(ConsumerLoop, PollsWhileItWaits) {
  FixedSize scheme;
  Rig rig(scheme);
  Package package;
  int polls = 0;
  EXPECT_EQ(rig.loop.next(package, 50ms, [&] { ++polls; }), Next::idle);
  EXPECT_EQ(polls, 2) << "after 20 and 40 ms";
  EXPECT_EQ(rig.loop.next(package, 20ms, [&] { ++polls; }), Next::idle);
  EXPECT_EQ(polls, 2) << "the caller is back in time to look himself";
  const auto stop = [] { throw std::runtime_error("Ctrl-C"); };
  EXPECT_THROW(rig.loop.next(package, std::chrono::nanoseconds::max(), stop), std::runtime_error);
  rig.push(test::evenly_spaced(2000, 1));
  EXPECT_EQ(rig.loop.next(package, std::chrono::nanoseconds::max(), stop), Next::package);
}

TEST(ConsumerLoop, EndsWhenNothingOfTheRestIsKept) {
  test::ScriptedScheme scheme([](const Backlog& backlog) {
    return backlog.due ? Decision::take(backlog.count, 0.0) : Decision::wait_for(100);
  });
  Rig rig(scheme);
  rig.push(test::evenly_spaced(10, 1));
  rig.buffer.close();
  Package package;
  EXPECT_EQ(rig.loop.next(package, 10s), Next::ended);
  EXPECT_EQ(rig.telemetry.discarded, 10u);
  EXPECT_LT(rig.clock.now_ns(), 5'000'000'000) << "it has slept";
}

TEST(ConsumerLoop, TimesTheAlgorithm) {
  FixedSize scheme({.size = 2});
  Rig rig(scheme);
  rig.push(test::evenly_spaced(2, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 10s), Next::package);
  EXPECT_EQ(package.events.size(), 2u);
  std::this_thread::sleep_for(20ms);
  rig.loop.complete(package);
  EXPECT_GE(rig.telemetry.log[0].processing_us, 20'000.0);
  EXPECT_EQ(rig.telemetry.delivered, 2u);
}

TEST(ConsumerLoop, NoPackageStartsBeforeItsNewestEventCame) {
  Greedy scheme;
  Rig rig(scheme, 3'600'000'000'000);
  constexpr std::int64_t kUntil_us = 300'000;
  std::jthread producer([&] {
    for (std::int64_t t = 0; t < kUntil_us;) {
      t = rig.clock.now_ns() / 1000;
      rig.push(test::at_times({t}));
    }
    rig.buffer.close();
    rig.doorbell.wake();
  });
  std::int64_t early_us = 0;
  Package package;
  while (rig.loop.next(package, 20s) == Next::package) {
    early_us = std::max(early_us, package.t_last() - package.start_ns / 1000);
    rig.loop.complete(package);
  }
  EXPECT_EQ(early_us, 0);
}

TEST(ConsumerLoop, IsWokenByThePushThatCompletesAPackage) {
  FixedSize scheme({.size = 3});
  Rig rig(scheme, 3'600'000'000'000);
  std::thread producer([&] {
    const test::Events events = test::evenly_spaced(3, 1);
    for (std::size_t i = 0; i < 3; ++i) {
      std::this_thread::sleep_for(5ms);
      rig.push(EventSpan(events).subspan(i, 1));
    }
  });
  Package package;
  EXPECT_EQ(rig.loop.next(package, 20s), Next::package);
  EXPECT_EQ(package.events.size(), 3u);
  EXPECT_LT(package.start_ns, 10'000'000'000);
  producer.join();
}

TEST(ConsumerLoop, FlushesAtTheBoundWithoutAPush) {
  FixedSize scheme({.size = 1000});
  Rig rig(scheme, 30'000'000);
  rig.push(test::evenly_spaced(3, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 20s), Next::package);
  EXPECT_EQ(package.events.size(), 3u);
  EXPECT_GE(package.start_ns, 30'000'000);
  EXPECT_LT(package.start_ns, 10'000'000'000);
}

TEST(ConsumerLoop, DeliversTheRestWhenTheSourceEnds) {
  FixedSize scheme({.size = 1000});
  Rig rig(scheme, 3'600'000'000'000);
  std::thread producer([&] {
    rig.push(test::evenly_spaced(3, 1));
    std::this_thread::sleep_for(5ms);
    rig.buffer.close();
    rig.doorbell.wake();
  });
  Package package;
  ASSERT_EQ(rig.loop.next(package, 20s), Next::package);
  EXPECT_EQ(package.events.size(), 3u);
  EXPECT_LT(package.start_ns, 10'000'000'000);
  rig.loop.complete(package);
  EXPECT_EQ(rig.loop.next(package, 20s), Next::ended);
  EXPECT_EQ(rig.loop.next(package, 20s), Next::ended);
  producer.join();
}

// The source ends after the loop has looked, and before it sleeps.
TEST(ConsumerLoop, DoesNotOversleepTheEnd) {
  Rig* the_rig = nullptr;
  test::ScriptedScheme scheme([&](const Backlog&) {
    the_rig->buffer.close();
    the_rig->doorbell.wake();
    return Decision::wait_for(1000);
  });
  Rig rig(scheme, 3'600'000'000'000);
  the_rig = &rig;
  rig.push(test::evenly_spaced(3, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 20s), Next::package);
  EXPECT_LT(package.start_ns, 10'000'000'000);
}

// ---- work: whole, or part by part

struct Trouble {};

Decision within(std::int64_t budget_ns, std::size_t raw) {
  Decision decision = Decision::take(raw);
  decision.budget_ns = budget_ns;
  return decision;
}

constexpr std::int64_t kMinute_ns = 60'000'000'000;

TEST(ConsumerLoop, AWholePackageIsOnePart) {
  FixedSize scheme({.size = 640});
  Rig rig(scheme);
  rig.push(test::evenly_spaced(640, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 10s), Next::package);
  int calls = 0;
  rig.loop.work(package, [&](const Package& part) {
    ++calls;
    EXPECT_EQ(part.events.size(), 640u);
    EXPECT_FALSE(part.continues);
    std::this_thread::sleep_for(5ms);
  });
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(rig.telemetry.delivered, 640u);
  EXPECT_GE(rig.telemetry.log[0].processing_us, 5000.0);
  EXPECT_EQ(rig.buffer.size(), 0u);
}

TEST(ConsumerLoop, AnAnytimePackageComesPartByPart) {
  test::ScriptedScheme scheme([](const Backlog&) { return within(kMinute_ns, 640); });
  Rig rig(scheme);
  const test::Events events = test::evenly_spaced(640, 1);
  rig.push(events);
  Package package;
  ASSERT_EQ(rig.loop.next(package, 10s), Next::package);
  test::Events seen;
  std::vector<bool> continues;
  rig.loop.work(package, [&](const Package& part) {
    EXPECT_EQ(part.events.size(), 64u);
    EXPECT_EQ(part.index, 0u);
    EXPECT_EQ(part.start_ns, package.start_ns);
    EXPECT_EQ(rig.telemetry.delivered, 0u);
    seen.insert(seen.end(), part.events.begin(), part.events.end());
    continues.push_back(part.continues);
  });
  EXPECT_EQ(seen, events);
  std::vector<bool> expected(10, true);
  expected[0] = false;
  EXPECT_EQ(continues, expected);
  EXPECT_EQ(rig.telemetry.log.size(), 1u);
  EXPECT_EQ(rig.telemetry.delivered, 640u);
}

// The steady clock stands between the parts: what an overlong one has cost thins the next.
TEST(ConsumerLoop, LooksAtTheClockBetweenParts) {
  test::ScriptedScheme scheme([](const Backlog& backlog) {
    return backlog.count < 640 ? Decision::take(backlog.count) : within(4'000'000, 640);
  });
  Rig rig(scheme, 100 * kMinute_ns);  // a grace of a minute
  rig.push(test::evenly_spaced(640, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 10s), Next::package);
  std::vector<std::size_t> sizes;
  rig.loop.work(package, [&](const Package& part) {
    sizes.push_back(part.events.size());
    if (sizes.size() == 1) std::this_thread::sleep_for(5ms);
  });
  ASSERT_GE(sizes.size(), 2u);
  EXPECT_EQ(sizes[0], 64u);
  EXPECT_LT(sizes[1], 32u);
  EXPECT_GE(rig.telemetry.log[0].processing_us, 5000.0);
  EXPECT_EQ(rig.telemetry.log[0].offered, 640);
}

TEST(ConsumerLoop, AStallLeavesTheRestToTheNextPackage) {
  test::ScriptedScheme scheme([](const Backlog& backlog) { return within(1, backlog.count); });
  Rig rig(scheme, 100'000);  // a grace of a microsecond
  rig.push(test::evenly_spaced(640, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 10s), Next::package);
  int calls = 0;
  rig.loop.work(package, [&](const Package&) {
    ++calls;
    std::this_thread::sleep_for(1ms);
  });
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(rig.telemetry.log[0].offered, 64);
  EXPECT_EQ(rig.buffer.size(), 576u);
}

TEST(ConsumerLoop, APackageOfWhichNothingIsKeptRunsNoAlgorithm) {
  test::ScriptedScheme scheme([](const Backlog& backlog) {
    Decision decision = within(-1, backlog.count);
    decision.keep = 0.0;
    decision.event_ns = 1.0;
    return decision;
  });
  Rig rig(scheme);
  rig.push(test::evenly_spaced(640, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 10s), Next::package);
  rig.loop.work(package, [](const Package&) { FAIL(); });
  EXPECT_EQ(rig.telemetry.discarded, 640u);
  EXPECT_EQ(rig.buffer.size(), 0u);
}

TEST(ConsumerLoop, AnExceptionLeavesThePackageInTheRing) {
  test::ScriptedScheme scheme([](const Backlog&) { return within(kMinute_ns, 640); });
  Rig rig(scheme);
  rig.push(test::evenly_spaced(1000, 1));
  Package package;
  ASSERT_EQ(rig.loop.next(package, 10s), Next::package);
  int calls = 0;
  EXPECT_THROW(rig.loop.work(package,
                             [&](const Package&) {
                               if (++calls == 3) throw Trouble{};
                             }),
               Trouble);
  EXPECT_EQ(rig.telemetry.delivered + rig.telemetry.discarded, 0u);
  EXPECT_EQ(rig.buffer.size(), 1000u);
}

}  // namespace
}  // namespace asap::consumer_loop_test
