// Threads against each other on rings of 1 to 32 events, with random batches; what comes out is
// compared event by event. Meant for ThreadSanitizer and noise at every atomic operation; the long
// form (ASAP_LONG_TESTS=1) sends 4 x 10^7 events through 20 schedules of each kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>

#include "../cpp/support/streams.hpp"
#include "asap/runner/pipeline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "buffer/arrival_times.hpp"
#include "buffer/event_buffer.hpp"
#include "core/random.hpp"
#include "noise.hpp"
#include "runner/doorbell.hpp"
#include "runner/push_door.hpp"

namespace asap {
namespace {

using namespace std::chrono_literals;
using test::Events;
using test::numbered;

constexpr auto kLost = 20s;  // who sleeps so long has lost a wake-up
constexpr std::size_t kLargestBatch = 64;

bool is_long() {
  const char* const asked = std::getenv("ASAP_LONG_TESTS");
  return asked != nullptr && std::string(asked) == "1";
}

struct Extent {
  std::uint64_t schedules;
  std::uint64_t events;  // of one schedule
};

// Draws the next number below `limit`; one per thread.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  std::size_t operator()(std::size_t limit) {
    return static_cast<std::size_t>(random_(next_++) % limit);
  }

 private:
  CounterRandom random_;
  std::uint64_t next_ = 0;
};

// Event i of a run.
Event event_of(std::uint64_t i) { return numbered(i, static_cast<std::int64_t>(i / 8)); }

void fill(Events& batch, std::uint64_t first) {
  for (Event& event : batch) event = event_of(first++);
}

// The producer pushes everything, waiting for room; a third thread gets in its way; the consumer
// looks in pieces of any size and sleeps when there is nothing.
void stream_through_the_ring(std::uint64_t seed, std::uint64_t events) {
  Draw draw(seed);
  EventBuffer ring(1 + draw(32), ~std::uint64_t{0} - draw(1000));
  ArrivalTimes times(1 + static_cast<std::int64_t>(draw(3)));
  Doorbell bell;
  PushDoor door;
  std::uint64_t pushed = 0;  // the producer's; after the door is shut, anybody's
  std::atomic<std::uint64_t> refused{0};
  const bool is_woken =
      draw(2) == 0;  // often, which would hide that the producer's bell is not heard
  door.open();

  std::jthread producer([&] {
    Draw draw_batch(seed + 1);
    Events batch;
    const std::uint64_t start = ring.tail();
    while (pushed < events) {
      if (!door.enter()) {
        std::this_thread::yield();  // the other may wait for this processor to get out
        continue;
      }
      batch.resize(std::min<std::uint64_t>(1 + draw_batch(kLargestBatch), events - pushed));
      fill(batch, pushed);
      times.note(ring.tail() - start, static_cast<std::int64_t>(pushed));
      const std::size_t room = std::min(batch.size(), ring.capacity() - ring.size());
      const std::size_t taken = ring.push(batch);
      EXPECT_GE(taken, room) << "dropped while there was room";
      pushed += taken;
      refused.fetch_add(batch.size() - taken, std::memory_order_relaxed);
      bell.announce(ring.tail());
      door.leave([] {});
      if (taken == 0) std::this_thread::yield();
    }
    ring.close();
    bell.wake();
  });
  std::jthread other([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const bool inside = door.enter();  // in the producer's way, at times
      if (is_woken) bell.wake();
      EXPECT_LE(ring.size(), ring.capacity());
      if (inside) door.leave([] {});
      std::this_thread::yield();  // outside: on one processor the producer would never get in
    }
  });

  Draw draw_look(seed + 2);
  const std::uint64_t start = ring.head();
  std::uint64_t seen = 0;
  std::int64_t last_ns = 0;
  for (;;) {
    const bool done = ring.closed();
    const EventPieces pieces = ring.peek(1 + draw_look(ring.capacity()));
    for (std::size_t i = 0; i < pieces.size(); ++i) ASSERT_EQ(pieces[i], event_of(seen + i));
    if (pieces.size() > 0) {
      const std::int64_t came_ns = times.of(seen);
      ASSERT_LE(last_ns, came_ns);
      ASSERT_LE(came_ns, static_cast<std::int64_t>(seen));
      last_ns = came_ns;
      seen += pieces.size();
      times.release(seen);
      ring.consume(pieces.size());
      continue;
    }
    if (done) break;
    const std::uint64_t wanted =
        start + seen + 1 + draw_look(std::min<std::size_t>(ring.capacity(), 2));
    const auto deadline = Doorbell::Clock::now() + kLost;
    bell.wait(wanted, deadline, [&] { return ring.tail() != start + seen || ring.closed(); });
    ASSERT_LT(Doorbell::Clock::now(), deadline) << "a wake-up was lost";
  }
  other.request_stop();
  door.shut();
  door.wait_until_empty();
  ASSERT_EQ(seen, events);
  ASSERT_EQ(pushed, events);
  ASSERT_EQ(ring.overflow(), refused);
}

// One run of a pipeline from its start to its end, while other threads look on, flush and get into
// the producer's way. The consumer is this thread. Returns what was pushed.
std::uint64_t run_once(Pipeline& pipeline, Draw& draw, std::uint64_t events) {
  std::atomic<std::uint64_t> pushed{0};
  const std::size_t largest = 1 + draw(kLargestBatch);
  const bool drain = draw(4) != 0;
  const bool from_callback = draw(4) == 0;
  std::jthread producer([&, seed = draw(1 << 30)] {
    Draw draw_batch(seed);
    Events batch;
    std::uint64_t next = 0;
    while (next < events) {
      batch.resize(1 + draw_batch(largest));
      fill(batch, next);
      if (pipeline.push(batch)) {
        next += batch.size();
      } else if (!pipeline.is_open()) {
        break;
      } else {
        std::this_thread::yield();
      }
    }
    pushed = next;
    if (!from_callback) pipeline.stop(drain);
  });
  std::uint64_t next = 0;
  std::uint64_t delivered = 0;
  std::uint64_t wrong = 0;
  pipeline.run(
      [&](const Package& package) {
        for (const Event& event : package.events) {
          const std::uint64_t number = test::number_of(event);
          if (number < next || event != event_of(number)) ++wrong;
          next = number + 1;
        }
        delivered += package.events.size();
        if (from_callback && next > events / 2) pipeline.stop(drain);
      },
      [&] {  // also if the events that it waits for never come
        if (from_callback) pipeline.stop(drain);
      });
  producer.join();
  const Ledger ledger = pipeline.ledger();
  EXPECT_EQ(wrong, 0u);
  EXPECT_TRUE(ledger.balanced());
  EXPECT_EQ(ledger.received, pushed);
  EXPECT_EQ(ledger.delivered, delivered);
  EXPECT_EQ(ledger.rejected, 0u);
  EXPECT_TRUE(!drain || ledger.pending == 0) << ledger.pending;
  return pushed;
}

std::uint64_t restart_again_and_again(std::uint64_t seed, std::uint64_t events) {
  Draw draw(seed);
  FixedSize by_size({.size = 1 + draw(20)});
  Greedy greedy;
  Scheme& scheme = draw(2) == 0 ? static_cast<Scheme&>(by_size) : greedy;
  const WhenFull rules[] = {WhenFull::thin, WhenFull::keep_oldest, WhenFull::keep_newest,
                            WhenFull::block};
  Pipeline pipeline(scheme,
                    {.latency = 2000us, .capacity = 1 + draw(32), .when_full = rules[seed % 4]});
  std::jthread watcher([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const PipelineStats stats = pipeline.stats();
      EXPECT_TRUE(stats.ledger.balanced());
      EXPECT_EQ(stats.latency.count(), stats.ledger.delivered);
      EXPECT_EQ(stats.packages.size, stats.ledger.delivered);
      EXPECT_LE(stats.ledger.delivered + stats.ledger.overflow, stats.ledger.received);
      pipeline.upstream_lost(1, 2);
      std::this_thread::yield();
    }
  });
  std::jthread flusher([&, latency = 1000us](const std::stop_token& stop) mutable {
    while (!stop.stop_requested()) {
      pipeline.flush();
      pipeline.push({});  // a second producer, who has nothing
      pipeline.set_latency(std::exchange(latency, 3000us - latency));
      std::this_thread::yield();
    }
  });
  std::uint64_t pushed = 0;
  while (pushed < events) {
    pushed += run_once(pipeline, draw, std::min(events - pushed, 1 + draw(events / 10)));
    pipeline.start();
  }
  pipeline.stop();
  return pushed;
}

// From quiet to loud.
std::uint32_t noise_of(std::uint64_t schedule) {
  return std::uint32_t{1} << (5 + 2 * ((schedule + schedule / 4) % 4));
}

TEST(Race, RingDoorbellDoorAndArrivalTimes) {
  const Extent extent = is_long() ? Extent{20, 1'000'000} : Extent{4, 200'000};
  const std::uint64_t before = test::noises();
  for (std::uint64_t schedule = 0; schedule < extent.schedules; ++schedule) {
    SCOPED_TRACE(schedule);
    test::make_noise(noise_of(schedule), schedule);
    stream_through_the_ring(10 * schedule, extent.events);
    if (HasFailure()) return;
  }
  std::printf("%llu noises\n", static_cast<unsigned long long>(test::noises() - before));
  EXPECT_GT(test::noises(), 0u);
}

// The end comes once in a run, so there are many.
TEST(Race, TheEndOfManyShortStreams) {
  const std::uint64_t runs = is_long() ? 20'000 : 1'000;
  for (std::uint64_t run = 0; run < runs; ++run) {
    SCOPED_TRACE(run);
    test::make_noise(8, run);
    stream_through_the_ring(7 * run, 1 + run % 50);
    if (HasFailure()) return;
  }
}

TEST(Race, PipelineWatchedFlushedChangedStoppedAndRestarted) {
  const Extent extent = is_long() ? Extent{20, 1'000'000} : Extent{4, 200'000};
  const std::uint64_t before = test::noises();
  std::uint64_t pushed = 0;
  for (std::uint64_t schedule = 0; schedule < extent.schedules; ++schedule) {
    SCOPED_TRACE(schedule);
    test::make_noise(noise_of(schedule), schedule);
    pushed += restart_again_and_again(1000 + schedule, extent.events);
    if (HasFailure()) return;
  }
  std::printf("%llu events, %llu noises\n", static_cast<unsigned long long>(pushed),
              static_cast<unsigned long long>(test::noises() - before));
  EXPECT_GE(pushed, extent.schedules * extent.events);
}

// A sensor's clock that is set back flushes on the producer's thread, while another one flushes.
TEST(Race, AnOlderFlushTakesNothingFromANewerOne) {
  const int rounds = is_long() ? 20'000 : 500;
  test::make_noise(8, 1);
  FixedSize waits({.size = 1000});
  Pipeline pipeline(waits, {.latency = 1h, .capacity = 64, .execution = Execution::whole});
  std::atomic<int> round{0};
  std::jthread other([&] {
    for (int seen = 0; seen < rounds;) {
      const int now = round;
      if (now != seen) pipeline.flush();
      seen = now;
    }
  });
  Package package;
  while (round < rounds) {
    ++round;
    pipeline.push(test::at_times({2'000'000}));
    pipeline.push(test::at_times(std::vector<std::int64_t>(Validator::kStays, 0)));
    const auto next = pipeline.next(package, kLost);
    if (next != Pipeline::Next::package) round = rounds;
    ASSERT_EQ(next, Pipeline::Next::package) << "what came before the new time is due";
    pipeline.complete();
    pipeline.flush();
    for (; pipeline.ledger().pending > 0; pipeline.complete()) pipeline.next(package, kLost);
  }
}

}  // namespace
}  // namespace asap
