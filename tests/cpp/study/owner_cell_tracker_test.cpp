#include "study/owner_cell_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <stdexcept>
#include <vector>

#include "algorithms/cluster_streams.hpp"
#include "study/blobs.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

namespace asap::owner_cell_tracker_test {
namespace {

// ---- OrphanNoise ----------------------------------------------------------------------------

void update(OrphanNoise& noise, int orphans, bool warming) {
  for (int i = 0; i < orphans; ++i) noise.count();
  noise.update(0.001F, 10'000, warming, 144, 0.015F);
}

TEST(OrphanNoise, FollowsTheRateQuicklyAtFirst) {
  OrphanNoise noise;
  update(noise, 20, true);  // 2 Hz per pixel
  EXPECT_FLOAT_EQ(noise.rate_hz(), 0.4F);
  update(noise, 20, true);
  EXPECT_FLOAT_EQ(noise.rate_hz(), 0.72F);
  update(noise, 0, false);
  EXPECT_FLOAT_EQ(noise.rate_hz(), 0.72F * 0.97F);
}

TEST(OrphanNoise, TheThresholdIsFourDeviationsAboveTheNoise) {
  OrphanNoise noise;
  EXPECT_EQ(noise.threshold(), std::numeric_limits<float>::infinity());
  for (int i = 0; i < 100; ++i) update(noise, 20, true);
  EXPECT_EQ(noise.threshold(), std::numeric_limits<float>::infinity());
  update(noise, 20, false);
  const float expected = 2 * 144 * 0.015F;
  EXPECT_NEAR(noise.threshold(), expected + 4 * std::sqrt(expected) + 2, 1e-3);
}

TEST(OrphanNoise, TheThresholdIsSixEventsAtLeast) {
  OrphanNoise noise;
  update(noise, 0, false);
  EXPECT_EQ(noise.threshold(), 6);
}

// ---- OwnerCellTracker -----------------------------------------------------------------------

using test::blobs;
using test::moving;
using test::Path;
using test::repeated;
using test::resting;

OwnerCellTracker tracker_of(int radius_px = 16) {
  return OwnerCellTracker({.width = 346, .height = 260, .radius_px = radius_px});
}

std::vector<std::int32_t> labels_of(OwnerCellTracker& tracker, const std::vector<Event>& events) {
  std::vector<std::int32_t> labels(events.size(), -7);
  tracker.process(events, labels);
  return labels;
}

std::set<std::int64_t> ids_of(const OwnerCellTracker& tracker) {
  std::set<std::int64_t> ids;
  for (const Cluster& cluster : tracker.clusters()) ids.insert(cluster.id);
  return ids;
}

// One cluster, number 0, at rest.
OwnerCellTracker with_blob(double x, double y, int radius_px = 16) {
  auto tracker = tracker_of(radius_px);
  tracker.process(blobs(0, 100'000, {resting(x, y)}));
  return tracker;
}

// As its prototype on this stream: eleven ids, ten clusters at the end.
TEST(OwnerCellTracker, FindsTheSquaresOfTheGoldenStream) {
  auto tracker = tracker_of();
  const auto labels = labels_of(tracker, test::golden_stream());
  EXPECT_EQ(tracker.clusters().size(), 10u);
  EXPECT_EQ(*std::max_element(labels.begin(), labels.end()), 10);
}

TEST(OwnerCellTracker, NothingIsBornDuringTheWarmUp) {
  auto tracker = tracker_of();
  const auto events = blobs(0, 60'000, {resting(100, 100)});
  const auto labels = labels_of(tracker, events);
  const auto first = std::find(labels.begin(), labels.end(), 0);
  ASSERT_NE(first, labels.end());
  const Event& event = events[static_cast<std::size_t>(first - labels.begin())];
  EXPECT_GE(event.t, 30'000);
  EXPECT_LT(event.t, 40'000);
  EXPECT_EQ(std::count(first, labels.end(), -1), 0);
}

TEST(OwnerCellTracker, TheGateIsACircleOfItsRadius) {
  auto tracker = with_blob(100, 100);
  EXPECT_EQ(labels_of(tracker, repeated(114, 100, 100'000, 1)), std::vector<std::int32_t>{0});
  EXPECT_EQ(labels_of(tracker, repeated(119, 100, 100'000, 1)), std::vector<std::int32_t>{-1});
  auto wide = with_blob(100, 100, 20);
  EXPECT_EQ(labels_of(wide, repeated(119, 100, 100'000, 1)), std::vector<std::int32_t>{0});
  EXPECT_EQ(labels_of(wide, repeated(123, 100, 100'000, 1)), std::vector<std::int32_t>{-1});
}

TEST(OwnerCellTracker, TheGateIsAnEllipseWhereTheClusterIsLonger) {
  auto tracker = tracker_of();
  std::vector<Event> bar;  // grows to 40 px
  for (std::int64_t t_us = 0; t_us < 200'000; t_us += 20) {
    const std::int64_t length = std::min<std::int64_t>(40, 15 + t_us / 6000);
    const std::int64_t x = 100 - length / 2 + t_us / 20 * 7 % length;
    bar.push_back(test::event_at(static_cast<int>(x), 100, t_us));
  }
  tracker.process(bar);
  const auto clusters = tracker.clusters();
  ASSERT_EQ(clusters.size(), 1u);
  EXPECT_NEAR(clusters[0].x, 100, 3);
  EXPECT_NEAR(clusters[0].cxx, 40 * 40 / 12, 30);
  EXPECT_EQ(labels_of(tracker, repeated(126, 100, 200'000, 1)), std::vector<std::int32_t>{0});
  EXPECT_EQ(labels_of(tracker, repeated(100, 126, 200'000, 1)), std::vector<std::int32_t>{-1});
}

TEST(OwnerCellTracker, TheMeanRemembersAHundredEventsAndFewerOfThinnedStreams) {
  const auto step = [](double gamma) {
    auto tracker = with_blob(100, 100);
    tracker.set_keep(gamma);
    const double before = tracker.clusters()[0].x;
    tracker.process(repeated(112, 100, 99'950, 1));
    return (tracker.clusters()[0].x - before) / (112 - before);
  };
  EXPECT_NEAR(step(1), 1.0 / 100, 1e-4);
  EXPECT_NEAR(step(0.5), 1.0 / 100, 1e-4);
  EXPECT_NEAR(step(0.2), 1.0 / 40, 1e-4);
  EXPECT_NEAR(step(0), 1.0 / 20, 1e-4);
}

TEST(OwnerCellTracker, KnowsVelocityAndPredictsPositions) {
  auto tracker = tracker_of();
  const auto events = blobs(0, 500'000, {moving(60, 60, 200, 100)});
  tracker.process(events);
  const auto clusters = tracker.clusters();
  ASSERT_EQ(clusters.size(), 1u);
  EXPECT_NEAR(clusters[0].x, 160, 3);
  EXPECT_NEAR(clusters[0].y, 110, 3);
  EXPECT_NEAR(clusters[0].vx, 200, 20);
  EXPECT_NEAR(clusters[0].vy, 100, 20);
  EXPECT_EQ(clusters[0].t_last, events.back().t);
  const auto later = tracker.clusters_at(events.back().t + 20'000);
  EXPECT_NEAR(later[0].x - clusters[0].x, 0.02 * clusters[0].vx, 1e-3);
}

TEST(OwnerCellTracker, IdsEndWithTheEvents) {
  auto tracker = with_blob(100, 100);
  EXPECT_EQ(ids_of(tracker), std::set<std::int64_t>{0});
  tracker.process(blobs(100'000, 400'000, {resting(250, 200)}));
  EXPECT_EQ(ids_of(tracker), std::set<std::int64_t>{1});
}

// 330 events per second are too few for a confirmation, and the unassociated ones are too few for a
// birth. Six more confirm an existing cluster, but not one that begins with them.
TEST(OwnerCellTracker, ATentativeClusterDiesAfter60Milliseconds) {
  const auto clusters_after = [](std::int64_t last_us) {
    auto tracker = tracker_of();
    tracker.process(repeated(300, 200, 0, 1));
    tracker.process(repeated(300, 200, 35'000, 1));
    tracker.process(repeated(100, 100, 40'000, 8));
    std::int64_t t_us = 40'000;
    for (; t_us <= last_us; t_us += 3'030) tracker.process(repeated(100, 100, t_us, 1));
    tracker.process(repeated(100, 100, t_us, 6));
    tracker.process(repeated(300, 200, t_us + 1'100, 1));
    return tracker.clusters().size();
  };
  EXPECT_EQ(clusters_after(90'000), 1u);
  EXPECT_EQ(clusters_after(150'000), 0u);
}

TEST(OwnerCellTracker, TwoThatComeToRestTogetherBecomeTheOlder) {
  auto tracker = tracker_of();
  const Path comes = [](double t_s) { return test::Place{std::max(113.0, 200 - 300 * t_s), 100}; };
  const std::vector<Path> paths{resting(100, 100), comes};
  tracker.process(blobs(0, 200'000, paths));
  EXPECT_EQ(ids_of(tracker), (std::set<std::int64_t>{0, 1}));
  tracker.process(blobs(200'000, 600'000, paths));
  EXPECT_EQ(ids_of(tracker), std::set<std::int64_t>{0});
  EXPECT_NEAR(tracker.clusters()[0].x, 106, 4);
}

TEST(OwnerCellTracker, TwoThatPassEachOtherStayTwo) {
  auto tracker = tracker_of();
  const std::vector<Path> paths{moving(60, 100, 300, 0), moving(240, 113, -300, 0)};
  tracker.process(blobs(0, 100'000, paths));
  const auto before = tracker.clusters();
  tracker.process(blobs(100'000, 500'000, paths));
  const auto after = tracker.clusters();
  ASSERT_EQ(before.size(), 2u);
  ASSERT_EQ(after.size(), 2u);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(after[i].id, before[i].id);
    EXPECT_GT(after[i].vx * before[i].vx, 0);
  }
}

// Its ellipse would hold both until they are 100 px apart.
TEST(OwnerCellTracker, AClusterThatComesApartIsSplit) {
  auto tracker = tracker_of();
  const auto side = [](double sign) {
    return [=](double t_s) {
      return test::Place{150 + sign * (7 + 60 * std::max(0.0, t_s - 0.1)), 100};
    };
  };
  const std::vector<Path> paths{side(-1), side(1)};
  tracker.process(blobs(0, 100'000, paths));
  ASSERT_EQ(tracker.clusters().size(), 1u);
  tracker.process(blobs(100'000, 500'000, paths));
  const auto clusters = tracker.clusters();
  ASSERT_EQ(clusters.size(), 2u);
  EXPECT_NEAR(std::abs(clusters[0].x - clusters[1].x), 2 * (7 + 24), 6);
}

std::vector<Event> noise(double hz, std::int64_t end_us) {
  const CounterRandom random(3);
  std::uint64_t draws = 0;
  const auto uniform = [&] { return random.uniform(draws++); };
  std::vector<Event> events;
  for (double t_us = 0; t_us < static_cast<double>(end_us);) {
    t_us += -std::log(1 - uniform()) * 1e6 / (hz * 346 * 260);
    const int x = static_cast<int>(346 * uniform());
    events.push_back(
        test::event_at(x, static_cast<int>(260 * uniform()), static_cast<std::int64_t>(t_us)));
  }
  return events;
}

TEST(OwnerCellTracker, PureNoiseIsMeasuredAndConfirmsNothing) {
  for (const double hz : {0.5, 5.0}) {
    auto tracker = tracker_of();
    const auto labels = labels_of(tracker, noise(hz, 500'000));
    EXPECT_EQ(*std::max_element(labels.begin(), labels.end()), -1) << hz;
    EXPECT_NEAR(tracker.noise_hz() / hz, 1, 0.1) << hz;
  }
}

TEST(OwnerCellTracker, AFullTableRefusesBirths) {
  auto tracker = OwnerCellTracker({.width = 1280, .height = 720});
  std::vector<Path> paths;
  for (int i = 0; i < 140; ++i) paths.push_back(resting(40 + 60 * (i % 20), 40 + 60 * (i / 20)));
  tracker.process(blobs(0, 100'000, paths));
  EXPECT_EQ(tracker.clusters().size(), OwnerCellTracker::kSlots);
}

TEST(OwnerCellTracker, SilenceOfMinutesEndsEverything) {
  auto tracker = with_blob(100, 100);
  const std::int64_t later_us = 100'000 + (std::int64_t{1} << 32);
  EXPECT_EQ(labels_of(tracker, repeated(100, 100, later_us, 1)), std::vector<std::int32_t>{-1});
  EXPECT_TRUE(tracker.clusters().empty());
}

TEST(OwnerCellTracker, DoesNotAllocateNorDependOnTheCut) {
  const auto events = test::golden_stream();
  auto whole = tracker_of();
  auto cut = tracker_of();
  std::vector<std::int32_t> labels(events.size());
  std::vector<std::int32_t> single(events.size());
  const std::size_t before = test::allocations();
  whole.process(events, labels);
  for (std::size_t i = 0; i < events.size(); ++i) {
    cut.process(EventSpan(events).subspan(i, 1), std::span(single).subspan(i, 1));
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(labels, single);
  whole.set_keep(0.2);
  whole.reset();
  whole.process(events, single);
  EXPECT_EQ(labels, single);
}

TEST(OwnerCellTracker, BadInput) {
  auto tracker = tracker_of();
  EXPECT_EQ(labels_of(tracker, repeated(346, 0, 0, 1)), std::vector<std::int32_t>{-1});
  EXPECT_EQ(tracker.rejected(), 1u);
  std::vector<std::int32_t> labels(2);
  EXPECT_THROW(tracker.process(repeated(1, 1, 0, 1), labels), std::invalid_argument);
  EXPECT_THROW(tracker.set_keep(1.01), std::invalid_argument);
  EXPECT_THROW(tracker.set_keep(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_EQ(test::error_of([] { tracker_of(15); }).substr(0, 16), "radius_px = 15: ");
  EXPECT_EQ(test::error_of([] { tracker_of(24); }).substr(0, 16), "radius_px = 24: ");
}

}  // namespace
}  // namespace asap::owner_cell_tracker_test
