#include "algorithms/fast/report.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "asap/algorithms/cluster_tracker.hpp"

namespace asap::fast::report_test {
namespace {

TEST(Report, IsForTheClocksTime) {
  EventClock clock;
  clock.advance(5'000'000'000);
  Track track;
  TrackState state;
  track.id = 3;
  track.x = 10;
  track.vx = 100;
  track.sxy = 2;
  track.stamp = clock.now();
  state.mass = 7.6F;
  state.last_event = clock.now() - 30'000;  // the mean has moved on since
  clock.advance(5'000'010'000);
  const Cluster cluster = report(track, state, {.xx = 0.5F, .xy = 0.25F, .yy = 2}, clock);
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

constexpr Frame kFrame{.width = 346, .height = 260};
constexpr float kNoNoise = 0;

// Confirmed, at (100, 50), 100 px/s to the right, 5000 events/s until time 0.
struct Object {
  Settings settings{ClusterTrackerConfig{.width = 346, .height = 260}};
  Track track{};
  TrackState state{};

  Object() {
    track.phase = Phase::kConfirmed;
    track.x = 100;
    track.y = 50;
    track.vx = 100;
    track.sxx = track.syy = 32;
    state.age_s = 1;
    state.mass = 150;
    state.fast_rate_hz = state.slow_rate_hz = 5000;
  }

  bool in(std::uint32_t us) {
    const Tick tick(us, 1e-6F * static_cast<float>(us), kNoNoise, settings.lifecycle);
    return advance_without_events(track, state, tick, settings, kFrame);
  }
};

TEST(Prediction, ChangesLittleAtFirst) {
  Object object;
  EXPECT_TRUE(object.in(3000));
  EXPECT_EQ(predicted_mean(object.track, 3000).x, 100.3F);
  EXPECT_EQ(object.track.vx, 100);
  EXPECT_NEAR(object.state.mass, 150 * 0.905, 0.5);  // exp(-3 ms / 30 ms)
}

TEST(Prediction, AStarvedTrackSlowsDownAndIsNotListed) {
  Object object;
  EXPECT_TRUE(object.in(50'000));
  EXPECT_NEAR(object.track.vx, 60.7, 0.1);  // exp(-50 ms / 100 ms)
  EXPECT_NEAR(object.track.x, 103.93, 0.01);
  EXPECT_FALSE(Object().in(70'000));
  EXPECT_FALSE(Object().in(500'000));
}

TEST(Prediction, ATrackThatLeavesTheFrameIsNotListed) {
  Object object;
  object.track.x = 347.8F;
  EXPECT_TRUE(object.in(1000));
  object.track.x = 347.8F;
  EXPECT_FALSE(object.in(4000));
}

TEST(Prediction, TentativeTracksAreNotListed) {
  Object object;
  object.track.phase = Phase::kTentative;
  EXPECT_FALSE(object.in(1000));
}

TEST(Prediction, UsesCopiesAndSortsById) {
  const Object object;
  Tracks tracks(4);
  for (const std::int32_t id : {7, 3, 5}) {
    const Tracks::Slot slot = tracks.create(0, 0, 0);
    const std::uint16_t generation = tracks[slot].generation;
    tracks[slot] = object.track;
    tracks[slot].generation = generation;
    tracks[slot].id = id;
    tracks.state(slot) = object.state;
  }
  EventClock clock;
  const Stamp now = clock.now();
  for (const Tracks::Slot slot : tracks.active()) {
    tracks[slot].stamp = tracks.state(slot).kalman.stamp = now - 50'000;
  }
  const Tick tick(now, 0.05F, kNoNoise, object.settings.lifecycle);
  for (int time = 0; time < 2; ++time) {
    std::vector<Cluster> clusters;
    predict_clusters(tracks, clock, tick, object.settings, kFrame, clusters);
    ASSERT_EQ(clusters.size(), 3U);
    EXPECT_EQ(clusters[0].id, 3);
    EXPECT_EQ(clusters[1].id, 5);
    EXPECT_EQ(clusters[2].id, 7);
    for (const auto& cluster : clusters) EXPECT_NEAR(cluster.vx, 60.7, 0.1);
  }
  for (const Tracks::Slot slot : tracks.active()) {
    EXPECT_EQ(tracks[slot].vx, 100);
    EXPECT_EQ(tracks.state(slot).mass, 150);
  }
}

}  // namespace
}  // namespace asap::fast::report_test
