#include "algorithms/fast/report.hpp"

#include <gtest/gtest.h>

namespace report_test {
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
  track.stamp = clock.now();
  life.mass = 7.6F;
  life.last_event = clock.now() - 30'000;  // the mean has moved on since
  clock.advance(5'000'010'000);
  const asap::Cluster cluster = report(track, life, {.xx = 0.5F, .xy = 0.25F, .yy = 2}, clock);
  EXPECT_EQ(cluster.id, 3);
  EXPECT_NEAR(cluster.x, 11, 1e-5);
  EXPECT_EQ(cluster.vx, 100);
  EXPECT_EQ(cluster.cxy, 2);
  EXPECT_EQ(cluster.pxx, 0.5);
  EXPECT_EQ(cluster.pxy, 0.25);
  EXPECT_EQ(cluster.pyy, 2);
  EXPECT_EQ(cluster.size, 8);
  EXPECT_EQ(cluster.t_last, 5'000'000'000 - 30'000);
}

}  // namespace
}  // namespace report_test
