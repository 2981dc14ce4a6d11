#include "study/jaer_cluster_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "study/blobs.hpp"

namespace asap::jaer_cluster_tracker_test {
namespace {

using test::blobs;
using test::moving;
using test::repeated;

JaerClusterTracker tracker_of(int width = 640, int height = 480) {
  return JaerClusterTracker({.width = width, .height = height});
}

std::int32_t give(JaerClusterTracker& tracker, int x, int y, std::int64_t t_us, int count = 1) {
  std::vector<std::int32_t> labels(static_cast<std::size_t>(count));
  tracker.process(repeated(x, y, t_us, count), labels);
  return labels.back();
}

TEST(JaerClusterTracker, AnEventDrawsTheBoxNearerByATwentieth) {
  auto tracker = tracker_of();
  give(tracker, 100, 100, 0, 12);
  EXPECT_EQ(give(tracker, 110, 96, 0), 0);
  const auto clusters = tracker.clusters();
  ASSERT_EQ(clusters.size(), 1u);
  EXPECT_FLOAT_EQ(static_cast<float>(clusters[0].x), 100.5F);
  EXPECT_FLOAT_EQ(static_cast<float>(clusters[0].y), 99.8F);
  EXPECT_EQ(clusters[0].size, 13);
}

TEST(JaerClusterTracker, ABoxReachesLessThan16PixelsEachWay) {
  auto tracker = tracker_of();
  give(tracker, 100, 100, 0, 30);
  EXPECT_EQ(give(tracker, 115, 85, 0), 0);  // far by L1, yet in the square
  tracker.reset();
  give(tracker, 100, 100, 0, 30);
  EXPECT_EQ(give(tracker, 116, 100, 0), -1);
  EXPECT_EQ(give(tracker, 100, 84, 0), -1);
  EXPECT_EQ(give(tracker, 116, 100, 0, 12), 1);
}

TEST(JaerClusterTracker, IsVisibleAboveTenEventsOfTheLastTenMilliseconds) {
  auto tracker = tracker_of();
  EXPECT_EQ(give(tracker, 100, 100, 0, 10), -1);
  EXPECT_TRUE(tracker.clusters().empty());
  EXPECT_EQ(give(tracker, 100, 100, 0, 2), 0);
  EXPECT_EQ(tracker.clusters_at(1'800).size(), 1u);  // 12 exp(-.18) = 10.02
  EXPECT_EQ(tracker.clusters_at(1'900).size(), 0u);  // 9.92
}

TEST(JaerClusterTracker, AWeakBoxDiesAfterTenMillisecondsButNotBefore) {
  auto tracker = tracker_of();
  give(tracker, 100, 100, 0);
  give(tracker, 400, 400, 9'900);  // a tick
  EXPECT_EQ(give(tracker, 100, 100, 9'900, 12), 0);
  tracker.reset();
  give(tracker, 100, 100, 0, 12);
  give(tracker, 400, 400, 10'100);
  EXPECT_EQ(give(tracker, 100, 100, 10'100, 12), 2);
}

// Box 0 at 100, box 1 at 116, drawn to 115.8.
JaerClusterTracker two_boxes(int first, int second) {
  auto tracker = tracker_of();
  give(tracker, 100, 100, 0, first);
  give(tracker, 116, 100, 0, second);
  give(tracker, 112, 100, 0);
  return tracker;
}

TEST(JaerClusterTracker, BoxesCloserThan16PixelsBecomeTheHeavierOne) {
  auto tracker = two_boxes(30, 20);
  EXPECT_EQ(tracker.clusters().size(), 2u);
  give(tracker, 400, 400, 1'000);
  ASSERT_EQ(tracker.clusters().size(), 1u);
  EXPECT_EQ(tracker.clusters()[0].id, 0);
  EXPECT_EQ(tracker.clusters()[0].x, 100);
  EXPECT_EQ(tracker.clusters()[0].size, std::lround(51 * std::exp(-0.1)));

  auto other = two_boxes(20, 30);
  give(other, 400, 400, 1'000);
  ASSERT_EQ(other.clusters().size(), 1u);
  EXPECT_EQ(other.clusters()[0].id, 1);
  EXPECT_NEAR(other.clusters()[0].x, 115.8, 0.2);  // predicted: it was moving
}

TEST(JaerClusterTracker, BoxesWhoseDirectionsDifferByMoreThan60DegreesStayTwo) {
  // Box 0 is drawn towards a pixel, box 1 to the left, so that both move.
  const auto left_over = [](int x, int y) {
    auto tracker = tracker_of();
    give(tracker, 100, 100, 0, 20);
    give(tracker, 116, 100, 0, 20);
    give(tracker, 107, 100, 0);  // of box 0: 0.35 px to the right
    give(tracker, 110, 100, 0);  // of box 1
    give(tracker, 109, 100, 0);
    give(tracker, 400, 400, 1'000);
    EXPECT_EQ(tracker.clusters().size(), 2u);  // towards each other
    give(tracker, x, y, 1'000, 5);
    give(tracker, 110, 100, 1'000);
    give(tracker, 400, 400, 2'000);
    return tracker.clusters().size();
  };
  EXPECT_EQ(left_over(96, 100), 1u);
  EXPECT_EQ(left_over(106, 100), 2u);
  EXPECT_EQ(left_over(97, 114), 2u);
}

TEST(JaerClusterTracker, VelocityIsTheLowPassedDisplacement) {
  auto tracker = tracker_of();
  give(tracker, 100, 100, 0, 20);
  give(tracker, 110, 100, 0);  // 0.5 px
  give(tracker, 400, 400, 2'000);
  const double weight = 1 - std::exp(-0.1);
  ASSERT_EQ(tracker.clusters().size(), 1u);
  EXPECT_NEAR(tracker.clusters()[0].vx, weight * 0.5 / 0.002, 0.02);
  EXPECT_EQ(tracker.clusters()[0].vy, 0);
  EXPECT_NEAR(tracker.clusters_at(3'000)[0].x, 100.5 + 0.003 * tracker.clusters()[0].vx, 1e-3);
}

TEST(JaerClusterTracker, FollowsAnObjectWithOneId) {
  auto tracker = tracker_of();
  const auto events = blobs(0, 500'000, {moving(100, 100, 200, 100)});
  std::vector<std::int32_t> labels(events.size());
  tracker.process(events, labels);
  for (std::size_t i = 200; i < labels.size(); ++i) ASSERT_EQ(labels[i], 0) << i;
  const auto clusters = tracker.clusters();
  ASSERT_EQ(clusters.size(), 1u);
  EXPECT_NEAR(clusters[0].x, 200, 4);
  EXPECT_NEAR(clusters[0].y, 150, 4);
  EXPECT_NEAR(clusters[0].vx, 200, 60);
  EXPECT_NEAR(clusters[0].vy, 100, 60);
  EXPECT_EQ(clusters[0].t_last, events.back().t);
}

}  // namespace
}  // namespace asap::jaer_cluster_tracker_test
