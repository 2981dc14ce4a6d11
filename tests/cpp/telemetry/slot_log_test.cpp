#include "telemetry/slot_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "asap/core/random.hpp"
#include "support/streams.hpp"

namespace asap {

static bool operator==(const Slot& a, const Slot& b) {
  return a.slot == b.slot && a.received == b.received && a.delivered == b.delivered &&
         a.latency_max_ns == b.latency_max_ns;
}

static std::ostream& operator<<(std::ostream& out, const Slot& slot) {
  return out << slot.slot << ": " << slot.delivered << " of " << slot.received << ", "
             << slot.latency_max_ns << " ns";
}

namespace slot_log_test {
namespace {

using test::at_times;
using test::Events;
using Slots = std::vector<Slot>;

const TimeAxis kAxis(0, 1.0);

TEST(SlotLog, HasARowForEverySlotThatHoldsAnEvent) {
  SlotLog log;
  log.received(at_times({0, 999, 1000, 5000, 5001, 5999}));
  EXPECT_EQ(log.slots(), (Slots{{0, 2, 0, 0}, {1, 1, 0, 0}, {5, 3, 0, 0}}));
}

TEST(SlotLog, ASlotMayComeInPieces) {
  SlotLog log;
  log.received(at_times({0}));
  log.received({});
  log.received(at_times({1, 2, 1500}));
  log.received(at_times({1999, 2000}));
  EXPECT_EQ(log.slots(), (Slots{{0, 3, 0, 0}, {1, 2, 0, 0}, {2, 1, 0, 0}}));
}

TEST(SlotLog, TellsWhatWasDeliveredAndHowLate) {
  SlotLog log;
  const Events events = at_times({100, 900, 1100, 1900, 3000});
  log.received(events);
  log.delivered(EventSpan(events).first(3), 2'000'000, kAxis);
  EXPECT_EQ(log.slots(), (Slots{{0, 2, 2, 1'900'000}, {1, 2, 1, 900'000}, {3, 1, 0, 0}}));
  log.delivered(EventSpan(events).subspan(3, 1), 2'900'000, kAxis);
  EXPECT_EQ(log.slots()[1], (Slot{1, 2, 2, 1'000'000})) << "the later package is the later one";
  log.delivered({}, 9'000'000, kAxis);
  EXPECT_EQ(log.slots()[2], (Slot{3, 1, 0, 0}));
}

TEST(SlotLog, TheLargestLatencyStays) {
  SlotLog log;
  const Events events = at_times({0, 900});
  log.received(events);
  log.delivered(EventSpan(events).first(1), 1'000'000, kAxis);
  log.delivered(EventSpan(events).last(1), 1'100'000, kAxis);
  EXPECT_EQ(log.slots(), (Slots{{0, 2, 2, 1'000'000}}));
}

TEST(SlotLog, StampsBeforeZeroHaveSlotsOfTheirOwn) {
  SlotLog log;
  log.received(at_times({-2000, -1001, -1000, -1, 0}));
  EXPECT_EQ(log.slots(), (Slots{{-2, 2, 0, 0}, {-1, 2, 0, 0}, {0, 1, 0, 0}}));
}

TEST(SlotLog, LatencyIsOfTheRunsAxis) {
  SlotLog log;
  const Events events = at_times({5'000'500});
  log.received(events);
  log.delivered(events, 1'000'000, TimeAxis(5'000'500, 2.0));
  EXPECT_EQ(log.slots(), (Slots{{5000, 1, 1, 750'000}}));
}

TEST(SlotLog, AgreesWithACountEventByEvent) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const CounterRandom random(seed);
    const Events events = test::random_stream(seed, 5000, seed % 2 == 0 ? -100'000 : 0);
    const TimeAxis axis(events.front().t, 1.0);
    SlotLog log;
    std::map<std::int64_t, Slot> expected;
    std::size_t received = 0;
    std::size_t decided = 0;
    for (std::uint64_t round = 0; decided < events.size(); ++round) {
      const std::size_t more = std::min<std::size_t>(random(2 * round) % 300, 5000 - received);
      for (std::size_t i = received; i < received + more; ++i) {
        std::int64_t slot = events[i].t / 1000;
        while (slot * 1000 > events[i].t) --slot;
        ++expected.insert({slot, {slot, 0, 0, 0}}).first->second.received;
      }
      log.received(EventSpan(events).subspan(received, more));
      received += more;

      const std::size_t until = decided + random(2 * round + 1) % (received - decided + 1);
      Events kept;
      for (; decided < until; ++decided) {
        if (random(1'000'000 + decided) % 5 != 0) kept.push_back(events[decided]);
      }
      if (kept.empty()) continue;
      const std::int64_t end_ns =
          axis.to_ns(kept.back().t) + 1000 * static_cast<std::int64_t>(round);
      log.delivered(kept, end_ns, axis);
      for (const Event& event : kept) {
        std::int64_t number = event.t / 1000;
        while (number * 1000 > event.t) --number;
        Slot& slot = expected.at(number);
        ++slot.delivered;
        slot.latency_max_ns = std::max(slot.latency_max_ns, end_ns - axis.to_ns(event.t));
      }
    }
    Slots rows;
    for (const auto& [number, slot] : expected) rows.push_back(slot);
    ASSERT_EQ(log.slots(), rows) << "seed " << seed;
  }
}

}  // namespace
}  // namespace slot_log_test
}  // namespace asap
