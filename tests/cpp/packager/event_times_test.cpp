#include "packager/event_times.hpp"

#include <gtest/gtest.h>

#include "support/streams.hpp"

namespace asap::event_times_test {
namespace {

// ---- EventTimes -----------------------------------------------------------------------------

TEST(EventTimes, ByStampLooksAtTheEvents) {
  const AgeSlots ages(1'000'000);
  EventTimes times(ages);
  times.set_axis(TimeAxis(1'000'000, 2.0));
  const test::Events events = test::evenly_spaced(10, 4, 1'000'000);  // 2 us of run time apart
  const EventPieces waiting{EventSpan(events).first(6), EventSpan(events).last(4)};
  EXPECT_FALSE(times.by_arrival());
  EXPECT_EQ(times.of(events[3], 77), 6000);
  EXPECT_EQ(times.before(6001, waiting, 77), 4u);
  EXPECT_EQ(times.before(16'000, waiting, 77), 8u);
  EXPECT_EQ(times.same_until(77, 87), 87u);
}

TEST(EventTimes, ByArrivalLooksAtTheirPlaceOnly) {
  ArrivalTimes arrivals(10);
  arrivals.note(0, 500);
  arrivals.note(4, 600);
  EventTimes times(arrivals);
  const test::Events events = test::evenly_spaced(10, 0);
  const EventPieces waiting{events, {}};
  EXPECT_TRUE(times.by_arrival());
  EXPECT_EQ(times.of(events[3], 3), 500);
  EXPECT_EQ(times.of(events[4], 4), 600);
  EXPECT_EQ(times.before(501, waiting, 0), 4u);
  EXPECT_EQ(times.about_before(501, 700, waiting, 0), 4u);
  EXPECT_EQ(times.same_until(1, 10), 4u);
  times.release(4);
  EXPECT_EQ(times.of(events[9], 9), 600);
}

// ---- KeptTimes ------------------------------------------------------------------------------

TEST(KeptTimes, LeavesOutWhatKeptNothing) {
  KeptTimes times(4);
  times.note(0, 100);
  times.note(3, 200);
  times.note(3, 300);
  times.note(8, 400);
  ASSERT_EQ(times.runs().size(), 2u);
  EXPECT_EQ(times.runs()[0].end, 3u);
  EXPECT_EQ(times.runs()[0].time_ns, 200);
  EXPECT_EQ(times.runs()[1].end, 8u);
  EXPECT_EQ(times.runs()[1].time_ns, 400);
  times.clear();
  EXPECT_TRUE(times.runs().empty());
}

}  // namespace
}  // namespace asap::event_times_test
