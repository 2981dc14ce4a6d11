#include "algorithms/fast/foresight.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "asap/algorithms/cluster_tracker_config.hpp"

namespace foresight_test {
namespace {

using namespace asap::fast;

constexpr Frame kFrame{.width = 346, .height = 260};
constexpr float kNoNoise = 0;

// Confirmed, at (100, 50), 100 px/s to the right, 5000 events/s until time 0.
struct Object {
  Settings settings{asap::ClusterTrackerConfig{.width = 346, .height = 260}};
  Track track{};
  Life life{};

  Object() {
    track.phase = Phase::kConfirmed;
    track.x = 100;
    track.y = 50;
    track.vx = 100;
    track.sxx = track.syy = 32;
    life.age_s = 1;
    life.mass = 150;
    life.fast_rate_hz = life.slow_rate_hz = 5000;
  }

  bool in(std::uint32_t us) {
    const Tick tick(us, 1e-6F * static_cast<float>(us), kNoNoise, settings.life);
    return live_on(track, life, tick, settings, kFrame);
  }
};

TEST(Foresight, AShortWhileLaterAllIsAsItWas) {
  Object object;
  EXPECT_TRUE(object.in(3000));
  EXPECT_EQ(sight_of(object.track, 3000, 0, 0).mean_x, 100.3F);
  EXPECT_EQ(object.track.vx, 100);
  EXPECT_NEAR(object.life.mass, 150 * 0.905, 0.5);  // exp(-3 ms / 30 ms)
}

TEST(Foresight, WhatSeesNoEventsSlowsDownAndHides) {
  Object object;
  EXPECT_TRUE(object.in(50'000));
  EXPECT_NEAR(object.track.vx, 60.7, 0.1);  // exp(-50 ms / 100 ms)
  EXPECT_NEAR(object.track.x, 103.93, 0.01);
  EXPECT_FALSE(Object().in(70'000));
  EXPECT_FALSE(Object().in(500'000));
}

TEST(Foresight, WhatLeavesTheFrameIsNotListed) {
  Object object;
  object.track.x = 347.8F;
  EXPECT_TRUE(object.in(1000));
  object.track.x = 347.8F;
  EXPECT_FALSE(object.in(4000));
}

TEST(Foresight, TentativeOnesAreNotListed) {
  Object object;
  object.track.phase = Phase::kTentative;
  EXPECT_FALSE(object.in(1000));
}

TEST(Foresight, LooksAtCopiesAndSortsById) {
  const Object object;
  Tracks tracks(4);
  for (const std::int32_t id : {7, 3, 5}) {
    const Tracks::Slot slot = tracks.create(0, 0, 0);
    const std::uint16_t generation = tracks[slot].generation;
    tracks[slot] = object.track;
    tracks[slot].generation = generation;
    tracks[slot].id = id;
    tracks.life(slot) = object.life;
  }
  EventClock clock;
  const Stamp now = clock.now();
  for (const Tracks::Slot slot : tracks.active()) {
    tracks[slot].stamp = tracks.life(slot).kalman.stamp = now - 50'000;
  }
  const Tick tick(now, 0.05F, kNoNoise, object.settings.life);
  for (int time = 0; time < 2; ++time) {
    std::vector<asap::Cluster> clusters;
    foresee(tracks, clock, tick, object.settings, kFrame, clusters);
    ASSERT_EQ(clusters.size(), 3U);
    EXPECT_EQ(clusters[0].id, 3);
    EXPECT_EQ(clusters[1].id, 5);
    EXPECT_EQ(clusters[2].id, 7);
    for (const auto& cluster : clusters) EXPECT_NEAR(cluster.vx, 60.7, 0.1);
  }
  for (const Tracks::Slot slot : tracks.active()) {
    EXPECT_EQ(tracks[slot].vx, 100);
    EXPECT_EQ(tracks.life(slot).mass, 150);
  }
}

}  // namespace
}  // namespace foresight_test
