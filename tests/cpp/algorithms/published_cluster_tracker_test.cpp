#include "asap/algorithms/published_cluster_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "algorithms/brute_force_moments.hpp"
#include "algorithms/cluster_streams.hpp"
#include "support/allocation_counter.hpp"

namespace published_cluster_tracker_test {
namespace {

using asap::Cluster;
using asap::Event;
using asap::PublishedClusterMotion;
using asap::PublishedClusterTracker;

std::vector<std::int32_t> labels_of(PublishedClusterTracker& tracker,
                                    const std::vector<Event>& events) {
  std::vector<std::int32_t> labels(events.size(), -7);
  tracker.process(events, labels);
  return labels;
}

TEST(PublishedClusterTracker, FindsTheTenSquaresOfTheGoldenStream) {
  PublishedClusterTracker tracker{{.width = 346, .height = 260, .probes = 0}};
  tracker.process(asap::test::golden_stream());
  const auto clusters = tracker.clusters();
  ASSERT_EQ(clusters.size(), 10U);
  const auto match =
      std::find_if(clusters.begin(), clusters.end(), [](const Cluster& c) { return c.size == 78; });
  ASSERT_NE(match, clusters.end());
  EXPECT_NEAR(match->x, 110.910256, 5e-7);
  EXPECT_NEAR(match->y, 193.884615, 5e-7);
}

TEST(PublishedClusterTracker, LabelsAreIdsOnceAClusterHasMinSizeEvents) {
  PublishedClusterTracker tracker{{.width = 100, .height = 100, .radius = 5, .min_size = 3}};
  const auto at = [](std::uint16_t x, std::int64_t t) {
    return Event{.x = x, .y = 50, .p = 0, .t = t};
  };
  const std::vector<Event> events{at(10, 0), at(80, 1), at(10, 2), at(80, 3),
                                  at(80, 4), at(10, 5), at(10, 6)};
  EXPECT_EQ(labels_of(tracker, events), (std::vector<std::int32_t>{-1, -1, -1, -1, 0, 1, 1}));
  const auto clusters = tracker.clusters();
  ASSERT_EQ(clusters.size(), 2U);
  EXPECT_EQ(clusters[0].id, 0);
  EXPECT_EQ(clusters[0].x, 80);
  EXPECT_EQ(clusters[0].size, 3);
  EXPECT_EQ(clusters[0].t_last, 4);
  EXPECT_EQ(clusters[1].id, 1);
  EXPECT_EQ(clusters[1].size, 4);
}

TEST(PublishedClusterTracker, AMergeKeepsTheSmallerId) {
  PublishedClusterTracker tracker{
      {.width = 100, .height = 10, .radius = 10, .probes = 0, .min_size = 2}};
  const auto at = [](std::uint16_t x) { return Event{.x = x, .y = 5, .p = 0, .t = 0}; };
  // The older-created at 30 gets its id second; one event between the two joins them.
  EXPECT_EQ(labels_of(tracker, {at(30), at(50), at(50), at(50), at(30), at(40)}),
            (std::vector<std::int32_t>{-1, -1, 0, 0, 1, 0}));
  ASSERT_EQ(tracker.clusters().size(), 1U);
  EXPECT_EQ(tracker.clusters()[0].id, 0);
  EXPECT_EQ(tracker.clusters()[0].size, 6);
}

TEST(PublishedClusterTracker, ResultsFollowFromTheSeed) {
  const auto events = asap::test::make_scene({.noise_hz = 5}, 30'000);
  PublishedClusterTracker tracker{{.width = 346, .height = 260, .seed = 3}};
  PublishedClusterTracker same{{.width = 346, .height = 260, .seed = 3}};
  PublishedClusterTracker other{{.width = 346, .height = 260, .seed = 4}};
  const auto labels = labels_of(tracker, events);
  EXPECT_EQ(labels_of(same, events), labels);
  EXPECT_NE(labels_of(other, events), labels);
}

// More big clusters than the probe index has keys.
TEST(PublishedClusterTracker, AllocatesNothingForManyClusters) {
  const auto events = asap::test::make_scene({.noise_hz = 5}, 50'000);
  PublishedClusterTracker tracker{{.width = 346, .height = 260, .radius = 2, .min_size = 0}};
  std::vector<Cluster> clusters;
  clusters.reserve(800);
  const std::size_t before = asap::test::allocations();
  tracker.process(events);
  tracker.clusters(clusters);
  EXPECT_EQ(asap::test::allocations(), before);
  EXPECT_GT(clusters.size(), 140U);
}

// A disc of uniformly random events that moves on a straight line.
std::vector<Event> moving_blob(std::int64_t start, double vx, double vy, std::int64_t step_us,
                               int count) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> offset(-4, 4);
  std::vector<Event> events;
  for (int i = 0; i < count; ++i) {
    const double t = 1e-6 * static_cast<double>(step_us) * i;
    events.push_back({.x = static_cast<std::uint16_t>(60 + vx * t + offset(random)),
                      .y = static_cast<std::uint16_t>(200 + vy * t + offset(random)),
                      .p = 1,
                      .t = start + step_us * i});
  }
  return events;
}

TEST(PublishedClusterTracker, MeasuresTheVelocityOfABlob) {
  for (const std::int64_t start : {std::int64_t{0}, std::int64_t{1'600'000'000'000'000}}) {
    PublishedClusterTracker tracker{{.width = 346, .height = 260}};
    tracker.process(moving_blob(start, 250, -150, 500, 2000));  // 1 s; the window holds 0.4 s
    const auto clusters = tracker.clusters();
    ASSERT_EQ(clusters.size(), 1U);
    EXPECT_NEAR(clusters[0].vx, 250, 5);
    EXPECT_NEAR(clusters[0].vy, -150, 5);
    EXPECT_NEAR(clusters[0].x, 60 + 250 * 0.8, 1);
  }
}

// A window of 20 minutes, where sums of squared microseconds no longer fit 64 bits.
TEST(PublishedClusterTracker, MeasuresTheVelocityOverAWindowOfMinutes) {
  for (const std::int64_t start : {std::int64_t{0}, std::int64_t{1'600'000'000'000'000}}) {
    PublishedClusterTracker tracker{{.width = 346, .height = 260}};
    const auto events = moving_blob(start, 0.1, -0.05, 1'500'000, 1200);
    tracker.process(events);
    const auto clusters = tracker.clusters();
    ASSERT_EQ(clusters.size(), 1U);
    ASSERT_EQ(clusters[0].size, 800);
    const asap::test::BruteForce truth(std::vector(events.end() - 800, events.end()));
    EXPECT_NEAR(clusters[0].vx / static_cast<double>(1e6 * truth.xt / truth.tt), 1, 1e-9);
    EXPECT_NEAR(clusters[0].vy / static_cast<double>(1e6 * truth.yt / truth.tt), 1, 1e-9);
  }
}

TEST(PublishedClusterTracker, MotionDecidesPositionAndVelocityAlone) {
  const auto events = asap::test::make_scene({.noise_hz = 5}, 30'000);
  PublishedClusterTracker published{{.width = 346, .height = 260}};
  PublishedClusterTracker filtered{
      {.width = 346, .height = 260, .motion = PublishedClusterMotion::kKalman}};
  EXPECT_EQ(labels_of(filtered, events), labels_of(published, events));
  const auto a = published.clusters();
  const auto b = filtered.clusters();
  ASSERT_EQ(a.size(), b.size());
  int others = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].size, b[i].size);
    EXPECT_EQ(a[i].t_last, b[i].t_last);
    EXPECT_EQ(a[i].cxy, b[i].cxy);
    others += a[i].x != b[i].x && a[i].vx != b[i].vx;
  }
  EXPECT_GT(others, 5);
}

TEST(PublishedClusterTracker, TheFilterMeasuresPositionAndVelocity) {
  for (const std::int64_t start : {std::int64_t{0}, std::int64_t{1'600'000'000'000'000}}) {
    PublishedClusterTracker tracker{
        {.width = 346, .height = 260, .motion = PublishedClusterMotion::kKalman}};
    tracker.process(moving_blob(start, 250, -150, 20, 50'000));  // 1 s; the window holds 16 ms
    const auto clusters = tracker.clusters();
    ASSERT_EQ(clusters.size(), 1U);
    EXPECT_NEAR(clusters[0].vx, 250, 50);
    EXPECT_NEAR(clusters[0].vy, -150, 50);
    EXPECT_NEAR(clusters[0].x, 59.5 + 250, 0.7);  // pixels are rounded down
    EXPECT_NEAR(clusters[0].y, 199.5 - 150, 0.7);
  }
}

TEST(PublishedClusterTracker, LooksAheadWithTheFilterAndChangesNothing) {
  PublishedClusterTracker tracker{
      {.width = 346, .height = 260, .motion = PublishedClusterMotion::kKalman}};
  const auto events = moving_blob(0, 250, -150, 20, 50'000);
  tracker.process(events);
  const auto now = tracker.clusters();
  ASSERT_EQ(now.size(), 1U);
  const auto x_at = [&](std::int64_t t_us) { return tracker.clusters_at(t_us)[0].x; };
  const std::int64_t last = events.back().t;
  EXPECT_EQ(x_at(last), now[0].x);
  EXPECT_EQ(x_at(last - 10'000), now[0].x);
  EXPECT_NEAR(x_at(last + 10'000), now[0].x + now[0].vx * 0.01, 1e-9);
  EXPECT_NEAR(x_at(last + 10'000'000), now[0].x + now[0].vx * 0.1, 2);
  EXPECT_EQ(x_at(last + 10'000'000), x_at(last + 20'000'000));
  EXPECT_EQ(tracker.clusters()[0].x, now[0].x);
  EXPECT_EQ(tracker.clusters_at(last + 10'000)[0].size, now[0].size);
}

TEST(PublishedClusterTracker, WithoutTheFilterNothingIsAhead) {
  PublishedClusterTracker tracker{{.width = 346, .height = 260}};
  const auto events = moving_blob(0, 250, -150, 500, 2000);
  tracker.process(events);
  EXPECT_EQ(tracker.clusters_at(events.back().t + 10'000)[0].x, tracker.clusters()[0].x);
}

// A cluster that never had min_size events absorbs one that had, and shrank: id and motion pass on.
TEST(PublishedClusterTracker, TheMotionGoesWithTheId) {
  PublishedClusterTracker tracker{{.width = 100,
                                   .height = 20,
                                   .window = 8,
                                   .radius = 10,
                                   .probes = 0,
                                   .weight = 0.5,
                                   .min_size = 4,
                                   .motion = PublishedClusterMotion::kKalman}};
  const auto at = [](std::uint16_t x) { return Event{.x = x, .y = 5, .p = 0, .t = 0}; };
  EXPECT_EQ(labels_of(tracker, {at(30), at(30), at(30), at(30), at(80), at(80), at(80), at(50),
                                at(50), at(50), at(40)}),
            (std::vector<std::int32_t>{-1, -1, -1, 0, -1, -1, -1, -1, -1, -1, 0}));
  ASSERT_EQ(tracker.clusters().size(), 1U);
  EXPECT_EQ(tracker.clusters()[0].size, 5);
  EXPECT_EQ(tracker.clusters()[0].x, 30);
}

// A stray event is older than the cluster that it becomes one with: the larger keeps its motion.
TEST(PublishedClusterTracker, TheMotionOfTheLargerSurvivesAMerge) {
  PublishedClusterTracker tracker{{.width = 100,
                                   .height = 20,
                                   .radius = 10,
                                   .probes = 0,
                                   .min_size = 3,
                                   .motion = PublishedClusterMotion::kKalman}};
  const auto at = [](std::uint16_t x) { return Event{.x = x, .y = 5, .p = 0, .t = 0}; };
  EXPECT_EQ(labels_of(tracker, {at(50), at(30), at(30), at(30), at(30), at(40)}),
            (std::vector<std::int32_t>{-1, -1, -1, 0, 0, 0}));
  ASSERT_EQ(tracker.clusters().size(), 1U);
  EXPECT_EQ(tracker.clusters()[0].x, 30);
}

}  // namespace
}  // namespace published_cluster_tracker_test
