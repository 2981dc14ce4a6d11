#include "asap/runner/recording_intake.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "support/streams.hpp"

namespace asap::recording_intake_test {
namespace {

using test::evenly_spaced;
using test::Events;

constexpr std::int64_t kBound_ns = 6'400'000;  // slots of 100 us

TEST(RecordingIntake, PushesInOrderAndCountsTheRestAsOverflow) {
  EventBuffer buffer(4);
  RecordingIntake intake(buffer, kBound_ns, nullptr);
  const Events events = evenly_spaced(6, 10);
  intake.push(events, TimeAxis(0, 1.0));
  EXPECT_EQ(test::numbers_of(buffer.peek().first), (std::vector<std::uint64_t>{0, 1, 2, 3}));
  EXPECT_EQ(buffer.overflow(), 2u);
}

TEST(RecordingIntake, NotesTheAgesOfWhatIsInTheRingOnTheAxis) {
  EventBuffer buffer(8);
  RecordingIntake intake(buffer, kBound_ns, nullptr);
  const TimeAxis twice_as_fast(0, 2.0);
  intake.push(evenly_spaced(8, 100), twice_as_fast);       // two in each slot
  intake.push(evenly_spaced(2, 100, 800), twice_as_fast);  // overflow: not in the ring
  EXPECT_EQ(intake.ages().before(200'000, 400'000, 0, 8), 4u);
  EXPECT_EQ(intake.ages().before(400'000, 400'000, 0, 8), 8u);
}

TEST(RecordingIntake, TellsTheMaskWhatFoundRoom) {
  EventBuffer buffer(2);
  KeptMask mask;
  RecordingIntake intake(buffer, kBound_ns, &mask);
  const Events events = evenly_spaced(3, 10);
  mask.passed().append(4, true);
  intake.push(events, TimeAxis(0, 1.0));
  mask.packaged(buffer.peek(), 2, EventSpan(events).first(2));
  buffer.consume(2);
  const Events last = evenly_spaced(1, 1, 30);
  intake.push(last, TimeAxis(0, 1.0));
  mask.packaged(buffer.peek(), 1, last);
  EXPECT_EQ(mask.read().kept, (std::vector<std::uint8_t>{1, 1, 0, 1}));
  EXPECT_EQ(mask.read().first, (std::vector<std::int64_t>{0, 3}));
}

}  // namespace
}  // namespace asap::recording_intake_test
