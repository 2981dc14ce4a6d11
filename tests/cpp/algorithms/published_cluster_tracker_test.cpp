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
using asap::PublishedClusterTracker;

std::vector<std::int32_t> labels_of(PublishedClusterTracker& tracker,
                                    const std::vector<Event>& events) {
  std::vector<std::int32_t> labels(events.size(), -7);
  tracker.process(events, labels);
  return labels;
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

TEST(PublishedClusterTracker, NothingIsAheadOfTheWindow) {
  PublishedClusterTracker tracker{{.width = 346, .height = 260}};
  const auto events = moving_blob(0, 250, -150, 500, 2000);
  tracker.process(events);
  EXPECT_EQ(tracker.clusters_at(events.back().t + 10'000)[0].x, tracker.clusters()[0].x);
}

}  // namespace
}  // namespace published_cluster_tracker_test
