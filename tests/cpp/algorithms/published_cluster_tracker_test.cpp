#include "asap/algorithms/published_cluster_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
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
using asap::PublishedClusterTrackerConfig;

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

TEST(PublishedClusterTracker, DropsAndCountsEventsOutsideTheFrame) {
  PublishedClusterTracker tracker{{.width = 20, .height = 10, .min_size = 1}};
  const auto at = [](std::uint16_t x, std::uint16_t y) {
    return Event{.x = x, .y = y, .p = 0, .t = 0};
  };
  EXPECT_EQ(labels_of(tracker, {at(20, 0), at(0, 10), at(65535, 65535), at(19, 9), at(0, 0)}),
            (std::vector<std::int32_t>{-1, -1, -1, 0, 1}));
  EXPECT_EQ(tracker.rejected(), 3U);
}

TEST(PublishedClusterTracker, LabelsOfAnotherSizeAreRefused) {
  PublishedClusterTracker tracker{{.width = 20, .height = 10}};
  const std::vector<Event> events(3, Event{.x = 0, .y = 0, .p = 0, .t = 0});
  std::vector<std::int32_t> labels(2);
  EXPECT_THROW(tracker.process(events, labels), std::invalid_argument);
  EXPECT_TRUE(tracker.clusters().empty());
}

std::string complaint(const std::function<void(PublishedClusterTrackerConfig&)>& spoil) {
  PublishedClusterTrackerConfig config{.width = 346, .height = 260};
  spoil(config);
  try {
    PublishedClusterTracker{config};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

TEST(PublishedClusterTracker, DefaultsAreTheLaunchValues) {
  const PublishedClusterTrackerConfig config{.width = 346, .height = 260};
  EXPECT_EQ(config.window, 800);
  EXPECT_EQ(config.radius, 20);
  EXPECT_EQ(config.probes, 1);
  EXPECT_EQ(config.weight, 0.9);
  EXPECT_EQ(config.min_size, 15);
  EXPECT_EQ(config.motion, PublishedClusterMotion::kWindow);
}

TEST(PublishedClusterTracker, ErrorsNameFieldValueAndRemedy) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(complaint([](auto& c) { c.width = 0; }), "width = 0: must be 1 to 65536 px");
  EXPECT_EQ(complaint([](auto& c) { c.height = 65537; }), "height = 65537: must be 1 to 65536 px");
  EXPECT_EQ(complaint([](auto& c) { c.window = 0; }), "window = 0: must be 1 to 65535 events");
  EXPECT_EQ(complaint([](auto& c) { c.window = 65536; }),
            "window = 65536: must be 1 to 65535 events");
  EXPECT_EQ(complaint([](auto& c) { c.radius = -1; }),
            "radius = -1: must be finite and at least 0 px");
  EXPECT_NE(complaint([](auto& c) { c.radius = kNan; }), "none");
  EXPECT_NE(complaint([](auto& c) { c.radius = kInfinity; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.probes = -1; }), "probes = -1: must be at least 0");
  EXPECT_EQ(complaint([](auto& c) { c.weight = 1.5; }), "weight = 1.5: must be in [0, 1]");
  EXPECT_EQ(complaint([](auto& c) { c.weight = -0.5; }), "weight = -0.5: must be in [0, 1]");
  EXPECT_NE(complaint([](auto& c) { c.weight = kNan; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.min_size = -1; }),
            "min_size = -1: must be at least 0 events");
}

TEST(PublishedClusterTracker, LimitsAreAllowed) {
  EXPECT_EQ(complaint([](auto& c) { c.width = 65536; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.window = 65535; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.radius = 0; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.weight = 0; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.weight = 1; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.min_size = 0; }), "none");
}

TEST(PublishedClusterTracker, KeepIsCheckedAndWithoutEffect) {
  const auto events = asap::test::golden_stream(3000);
  PublishedClusterTracker told{{.width = 346, .height = 260}};
  PublishedClusterTracker untold{{.width = 346, .height = 260}};
  told.set_keep(0.1);
  EXPECT_EQ(labels_of(told, events), labels_of(untold, events));
  EXPECT_NO_THROW(told.set_keep(0));
  EXPECT_NO_THROW(told.set_keep(1));
  EXPECT_THROW(told.set_keep(-0.1), std::invalid_argument);
  EXPECT_THROW(told.set_keep(1.1), std::invalid_argument);
  EXPECT_THROW(told.set_keep(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST(PublishedClusterTracker, ResultsFollowFromSeedAndEventsAlone) {
  const auto events = asap::test::make_scene({.noise_hz = 5}, 30'000);
  PublishedClusterTracker tracker{{.width = 346, .height = 260, .seed = 3}};
  PublishedClusterTracker other{{.width = 346, .height = 260, .seed = 4}};
  const auto labels = labels_of(tracker, events);
  EXPECT_NE(labels_of(other, events), labels);

  const std::vector<Event> outside{{.x = 346, .y = 0, .p = 0, .t = 0}};
  tracker.process(outside);
  tracker.reset();
  EXPECT_TRUE(tracker.clusters().empty());
  EXPECT_EQ(tracker.rejected(), 0U);
  EXPECT_EQ(labels_of(tracker, events), labels);

  // Cut into packages, and without asking for labels.
  tracker.reset();
  std::vector<std::int32_t> again(events.size());
  for (std::size_t i = 0; i < events.size();) {
    const std::size_t n = std::min<std::size_t>(1 + i % 997, events.size() - i);
    const asap::EventSpan package = asap::EventSpan(events).subspan(i, n);
    tracker.process(package, std::span(again).subspan(i, n));
    i += n;
  }
  EXPECT_EQ(again, labels);
  other = PublishedClusterTracker{{.width = 346, .height = 260, .seed = 3}};
  other.process(events);
  const auto a = tracker.clusters();
  const auto b = other.clusters();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].vx, b[i].vx);
  }
}

TEST(PublishedClusterTracker, AllocatesOnlyInTheConstructor) {
  const auto events = asap::test::make_scene({.noise_hz = 5}, 50'000);
  // The second setting has more big clusters than the probe index has keys.
  for (const asap::PublishedClusterTrackerConfig& config :
       {asap::PublishedClusterTrackerConfig{.width = 346, .height = 260, .probes = 2},
        asap::PublishedClusterTrackerConfig{
            .width = 346, .height = 260, .radius = 2, .min_size = 0},
        asap::PublishedClusterTrackerConfig{
            .width = 346, .height = 260, .motion = PublishedClusterMotion::kKalman}}) {
    PublishedClusterTracker tracker(config);
    std::vector<std::int32_t> labels(events.size());
    std::vector<Cluster> clusters;
    clusters.reserve(800);
    const std::size_t before = asap::test::allocations();
    tracker.process(events, labels);
    tracker.clusters(clusters);
    tracker.clusters_at(events.back().t + 1000, clusters);
    tracker.set_keep(0.5);
    tracker.reset();
    tracker.process(events);
    EXPECT_EQ(asap::test::allocations(), before);
    EXPECT_FALSE(clusters.empty());
  }
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

TEST(PublishedClusterTracker, TheFilterFollowsFromTheEventsAlone) {
  const auto events = asap::test::make_scene({.noise_hz = 5}, 30'000);
  const PublishedClusterTracker::Config config{
      .width = 346, .height = 260, .motion = PublishedClusterMotion::kKalman};
  PublishedClusterTracker whole(config);
  PublishedClusterTracker cut(config);
  whole.process(events);
  cut.process(asap::EventSpan(events).subspan(20'000));
  cut.reset();
  for (std::size_t i = 0; i < events.size(); i += 1000) {
    cut.process(asap::EventSpan(events).subspan(i, 1000));
  }
  const auto a = whole.clusters();
  const auto b = cut.clusters();
  ASSERT_EQ(a.size(), b.size());
  ASSERT_FALSE(a.empty());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].x, b[i].x);
    EXPECT_EQ(a[i].vx, b[i].vx);
  }
}

TEST(PublishedClusterTracker, SurvivesAnyStamps) {
  constexpr std::int64_t kLow = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kHigh = std::numeric_limits<std::int64_t>::max();
  PublishedClusterTracker tracker{
      {.width = 346, .height = 260, .window = 50, .probes = 2, .min_size = 3}};
  PublishedClusterTracker filtered{{.width = 346,
                                    .height = 260,
                                    .window = 50,
                                    .probes = 2,
                                    .min_size = 3,
                                    .motion = PublishedClusterMotion::kKalman}};
  std::mt19937_64 random(1);
  for (int i = 0; i < 3000; ++i) {
    const std::int64_t stamps[] = {kLow, kHigh, 0, -1, static_cast<std::int64_t>(random())};
    const Event event{.x = static_cast<std::uint16_t>(random() % 346),
                      .y = static_cast<std::uint16_t>(random() % 260),
                      .p = 0,
                      .t = stamps[random() % 5]};
    for (PublishedClusterTracker* each : {&tracker, &filtered}) {
      each->process({&event, 1});
      for (const Cluster& c : each->clusters_at(stamps[random() % 5])) {
        ASSERT_TRUE(std::isfinite(c.x) && std::isfinite(c.y));
        ASSERT_TRUE(std::isfinite(c.vx) && std::isfinite(c.vy));
      }
    }
  }
}

}  // namespace
}  // namespace published_cluster_tracker_test
