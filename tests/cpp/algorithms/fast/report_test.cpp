#include "asap/algorithms/fast/report.hpp"

#include <gtest/gtest.h>

namespace {

using namespace asap::fast;

TEST(Report, IsAsOfNow) {
  EventClock clock;
  clock.advance(5'000'000'000);
  Track track;
  Life life;
  track.id = 3;
  track.x = 10;
  track.vx = 100;
  track.sxy = 2;
  track.events = 12;
  track.stamp = clock.now();
  life.events = 10;
  life.mass = 7;
  clock.advance(5'000'010'000);
  const asap::Cluster fresh = report(track, life, clock);
  EXPECT_EQ(fresh.id, 3);
  EXPECT_NEAR(fresh.x, 11, 1e-5);
  EXPECT_EQ(fresh.vx, 100);
  EXPECT_EQ(fresh.cxy, 2);
  EXPECT_EQ(fresh.size, 9);
  EXPECT_EQ(fresh.t_last, 5'000'000'000);
  life.events = 12;  // the tick has moved the mean on since
  life.last_event = clock.now() - 30'000;
  EXPECT_EQ(report(track, life, clock).t_last, 5'000'010'000 - 30'000);
}

}  // namespace
