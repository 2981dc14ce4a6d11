// What a live pipeline shares between threads, under Relacy: door, arrival times, ring and doorbell
// together, put together as in pipeline.cpp and consumer_loop.cpp. A thread pushes
// until the door is shut, one stops, the last one out says that it is the end, one consumes until
// it has seen that; nobody has a deadline.
#include "buffer/arrival_times.hpp"
#include "buffer/event_buffer.hpp"
#include "runner/doorbell.hpp"
#include "runner/push_door.hpp"

namespace asap::model {
namespace {

using Ring = BasicEventBuffer<RelacyAtomics, 1>;  // goes back to the first slot when it can
using Bell = BasicDoorbell<RelacyAtomics, RelacySleep>;
using Door = BasicPushDoor<RelacyAtomics, RelacyWait>;
using Times = BasicArrivalTimes<RelacyAtomics, 32>;

constexpr Bell::Clock::time_point kNever = Bell::Clock::time_point::max();

std::int64_t time_of(std::uint64_t index) { return 10 * static_cast<std::int64_t>(index) + 10; }

template <unsigned capacity, unsigned total>
struct Live : rl::test_suite<Live<capacity, total>, 3> {
  RelacySleep::Queue queue;
  Ring ring{capacity};
  Times times{5};
  Bell bell;
  Door door;
  rl::var<unsigned> pushed;  // the producer's; the stopper's if nobody was inside

  void before() {
    RelacySleep::queue = &queue;
    pushed($) = 0;
    door.open();
  }

  void thread(unsigned index) {
    if (index == 0) produce();
    if (index == 1) stop();
    if (index == 2) consume();
  }

  void produce() {
    for (unsigned i = 0; i < total; ++i) {
      if (!door.enter()) return;
      const std::array<Event, 1> events{Event(i)};
      times.note(ring.tail(), time_of(i));
      ring.push(events);
      pushed($) += 1;
      bell.announce(ring.tail());
      door.leave([this] { close(); });
    }
  }

  void stop() {
    if (door.shut()) close();
  }

  void close() {
    RL_ASSERT(pushed($) == ring.tail() + ring.overflow());
    ring.close();
    bell.wake();
  }

  void consume() {
    std::uint64_t head = 0;
    unsigned next = 0;  // an event's number is at least this
    for (;;) {
      const bool done = ring.closed();
      const std::uint64_t end = head + ring.size();
      const EventPieces pieces = ring.peek();
      for (std::size_t i = 0; i < pieces.size(); ++i) {
        const unsigned number = pieces[i].number($);
        RL_ASSERT(number >= next);
        next = number + 1;
        RL_ASSERT(times.of(head + i) == time_of(number));
      }
      RL_ASSERT(end - head <= pieces.size());
      if (pieces.size() > 0) {
        const std::int64_t first_ns = times.of(head);
        RL_ASSERT(times.before(first_ns, head, pieces.size()) == 0);
        RL_ASSERT(times.together(head, head + pieces.size()).until == head + 1);
        head += pieces.size();
        times.release(head);
        ring.consume(pieces.size());
        continue;
      }
      if (done) break;
      const std::uint64_t wanted = head + 1;
      bell.wait(wanted, kNever, [&] { return ring.tail() >= wanted || ring.closed(); });
    }
    RL_ASSERT(ring.tail() == head);
  }
};

// The consumer wants more than ever comes; only who asks can wake it, as flush() does.
struct Flush : rl::test_suite<Flush, 3> {
  RelacySleep::Queue queue;
  Ring ring{2};
  Bell bell;
  RelacyAtomics::Atomic<std::uint64_t> due{0};
  RelacyAtomics::Atomic<bool> last{false};

  void before() { RelacySleep::queue = &queue; }

  void thread(unsigned index) {
    if (index == 0) {
      const std::array<Event, 2> events{Event(0), Event(1)};
      ring.push(EventSpan(events).first(1));
      bell.announce(ring.tail());
      ring.push(EventSpan(events).last(1));
      bell.announce(ring.tail());
    } else if (index == 1) {
      due.store(ring.tail(), std::memory_order_release);
      bell.wake();
      last.store(true, std::memory_order_release);
      bell.wake();
    } else {
      bool ended = false;
      while (!ended) {
        ended = last.load(std::memory_order_acquire);
        const std::uint64_t flush = due.load(std::memory_order_acquire);
        RL_ASSERT(flush <= ring.tail());
        const auto waiting = static_cast<std::size_t>(flush - ring.head());
        const EventPieces pieces = ring.peek(std::max<std::size_t>(waiting, 1));
        RL_ASSERT(pieces.size() >= waiting);
        ring.consume(waiting);
        if (ended) break;
        bell.wait(100, kNever, [&] {
          return due.load(std::memory_order_acquire) != flush ||
                 last.load(std::memory_order_acquire) != ended;
        });
      }
    }
  }
};

// Two sides that wait for each other: each tail is waited for, and rung for.
struct PingPong : rl::test_suite<PingPong, 2> {
  struct Side {
    RelacyAtomics::Atomic<std::uint64_t> tail{0};
    Bell bell;
    rl::var<unsigned> data;
  };
  RelacySleep::Queue queue;
  Side sides[2];

  void before() { RelacySleep::queue = &queue; }

  void thread(unsigned index) {
    Side& mine = sides[index];
    Side& other = sides[1 - index];
    for (unsigned round = 1; round <= 2; ++round) {
      if (index == 0) ring(other, round);
      wait(mine, round);
      if (index == 1) ring(other, round);
    }
  }

  static void ring(Side& side, unsigned round) {
    side.data($) = round;
    side.tail.store(round, std::memory_order_release);
    side.bell.announce(round);
  }

  static void wait(Side& side, unsigned round) {
    const auto there = [&] { return side.tail.load(std::memory_order_acquire) >= round; };
    while (!there()) side.bell.wait(round, kNever, there);
    RL_ASSERT(side.data($) == round);
  }
};

// Waits for far more than comes, is asked to look up, and then waits for less.
struct WantsLess : rl::test_suite<WantsLess, 3> {
  RelacySleep::Queue queue;
  Bell bell;
  RelacyAtomics::Atomic<std::uint64_t> tail{0};
  RelacyAtomics::Atomic<bool> asked{false};

  void before() { RelacySleep::queue = &queue; }

  void thread(unsigned index) {
    if (index == 0) {
      tail.store(1, std::memory_order_release);
      bell.announce(1);
    } else if (index == 1) {
      asked.store(true, std::memory_order_release);
      bell.wake();
    } else {
      const auto is_asked = [&] { return asked.load(std::memory_order_acquire); };
      while (!is_asked()) bell.wait(100, kNever, is_asked);
      const auto there = [&] { return tail.load(std::memory_order_acquire) == 1; };
      while (!there()) bell.wait(1, kNever, there);
    }
  }
};

// Two producers at one door, which is shut, twice, and opened again when it is empty.
struct TwoAtTheDoor : rl::test_suite<TwoAtTheDoor, 3> {
  Door door;
  rl::var<unsigned> pushed;
  rl::var<unsigned> ends;

  void before() {
    pushed($) = 0;
    ends($) = 0;
  }

  void thread(unsigned index) {
    if (index == 2) {
      for (unsigned round = 0; round < 2; ++round) {
        door.open();
        for (unsigned time = 0; time < 2; ++time) {
          if (door.shut()) end();
        }
        door.wait_until_empty();
        RL_ASSERT(ends($) == round + 1);
        pushed($) += 1;  // a race, unless nobody is inside
      }
      return;
    }
    for (unsigned i = 0; i < 2; ++i) {
      if (!door.enter()) continue;
      pushed($) += 1;
      door.leave([this] { end(); });
    }
  }

  void end() {
    pushed($) += 1;
    ends($) += 1;
  }
};

}  // namespace
}  // namespace asap::model

int main(int count, char** arguments) {
  using namespace asap::model;
  const Depth depth(count, arguments);
#ifdef BRIEF
  random<PingPong>("doorbell, two sides", depth);
  random<WantsLess>("doorbell, wants less", depth);
  random<TwoAtTheDoor>("door, two producers", depth);
  random<Live<2, 3>>("live, ring of 2", depth);
#else
  random<PingPong>("doorbell, two sides", depth);
  exhaustive<PingPong>("doorbell, two sides", depth);
  random<WantsLess>("doorbell, wants less", depth);
  exhaustive<WantsLess>("doorbell, wants less", depth);
  random<TwoAtTheDoor>("door, two producers", depth);
  exhaustive<TwoAtTheDoor>("door, two producers", depth);
  random<Flush>("flush", depth);
  exhaustive<Flush>("flush", depth);
  random<Live<1, 3>>("live, ring of 1", depth);
  random<Live<2, 3>>("live, ring of 2", depth);
  random<Live<3, 4>>("live, ring of 3", depth);
  random<Live<4, 5>>("live, ring of 4", depth);
  exhaustive<Live<1, 1>>("live, one event", depth);
#endif
}
