#include "runner/intake.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "support/streams.hpp"

namespace asap::intake_test {
namespace {

using test::evenly_spaced;
using test::Events;
using test::number_of;

struct Rig {
  explicit Rig(std::size_t capacity, WhenFull when_full)
      : buffer(capacity), intake(buffer, arrivals, doorbell, when_full, 3) {}

  std::uint64_t accounted() const { return buffer.tail() + buffer.overflow() + intake.discarded(); }
  // As the consumer does it.
  void consume(std::size_t count) {
    buffer.peek(count);
    buffer.consume(count);
    if (intake.room() != nullptr) intake.room()->announce(buffer.head());
  }

  EventBuffer buffer;
  ArrivalTimes arrivals{1};
  Doorbell doorbell;
  Intake intake;
};

// The room r goes to r q^2 / (q^2 + r m), whatever is pushed, and evenly over a push.
TEST(IntakeThin, APushLargerThanTheRoomIsThinnedOverAllOfItself) {
  for (const std::size_t waiting : {std::size_t{0}, std::size_t{60'000}, std::size_t{99'000}}) {
    for (const std::size_t count : {std::size_t{50'000}, std::size_t{300'000}}) {
      Rig rig(100'000, WhenFull::thin);
      rig.buffer.push(evenly_spaced(waiting, 1));
      rig.intake.take(evenly_spaced(count, 1), 0);
      EXPECT_EQ(rig.buffer.overflow(), 0u);
      EXPECT_EQ(rig.buffer.size() + rig.intake.discarded(), waiting + count);

      const std::size_t kept = rig.buffer.size() - waiting;
      const double quarter = 25'000;
      const double whole = std::max(100'000.0 - static_cast<double>(waiting) - quarter, 0.0);
      const double room = std::min(100'000.0 - static_cast<double>(waiting), quarter);
      const double thinned = static_cast<double>(count) - whole;
      const double law = whole + room - room / (1 + room * thinned / (quarter * quarter));
      if (thinned > 0) {
        EXPECT_NEAR(static_cast<double>(kept), law, 40) << waiting << ' ' << count;
      } else {
        EXPECT_EQ(kept, count);
      }
      const double tenth = static_cast<double>(kept) / 10;
      std::array<std::size_t, 10> tenths{};
      const EventPieces events = rig.buffer.peek();
      for (std::size_t i = waiting; i < events.size(); ++i) {
        ++tenths[number_of(events[i]) * 10 / count];
      }
      for (const std::size_t in_tenth : tenths) {
        EXPECT_NEAR(static_cast<double>(in_tenth), tenth, 4 * std::sqrt(tenth)) << waiting;
      }
    }
  }
}

TEST(IntakeThin, OneFreeSlotIsEnoughForAnyPushNotToOverflow) {
  for (const std::size_t capacity : {1U, 2U, 3U, 4U, 5U, 64U, 255U, 256U, 257U, 1000U, 4096U}) {
    Rig rig(capacity, WhenFull::thin);
    std::uint64_t pushed = 0;
    std::size_t size = 1;
    for (int push = 0; push < 300; ++push) {
      size = (size * 13 + 7) % (3 * capacity + 1000);
      rig.intake.take(evenly_spaced(size, 1), push);
      pushed += size;
      ASSERT_EQ(rig.buffer.overflow(), 0u) << capacity << ' ' << size;
      rig.consume(std::min<std::size_t>(rig.buffer.size(), 1));
    }
    EXPECT_EQ(rig.accounted(), pushed);
    EXPECT_GE(rig.buffer.size() + 1, capacity / 2);
  }
}

TEST(IntakeThin, TheTableSaysHowManyAreMissingBefore) {
  Rig rig(100, WhenFull::thin);
  for (int push = 0; push < 40; ++push) rig.intake.take(evenly_spaced(5, 1), 1000 * push);
  ASSERT_GT(rig.intake.discarded(), 30u);
  EXPECT_EQ(rig.arrivals.thinned(0), 0u);
  const std::uint64_t at_the_end = rig.arrivals.thinned(rig.buffer.tail() - 1);
  EXPECT_GT(at_the_end, 0u);
  EXPECT_LE(at_the_end, rig.intake.discarded());
}

}  // namespace
}  // namespace asap::intake_test
