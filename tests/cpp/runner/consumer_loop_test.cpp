#include "asap/runner/consumer_loop.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "asap/schemes/fixed_size.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap {
namespace {

using Next = ConsumerLoop::Next;
using namespace std::chrono_literals;

struct Rig {
  explicit Rig(Scheme& scheme, std::int64_t bound_ns = 10'000'000)
      : telemetry(bound_ns), packager(buffer, scheme, telemetry, 0) {
    packager.set_axis(TimeAxis(0, 1.0));
    clock.start(0);
  }

  void push(EventSpan events) {
    buffer.push(events);
    doorbell.announce(buffer.tail());
  }

  EventBuffer buffer{1024};
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

}  // namespace
}  // namespace asap
