#include "algorithms/fast/revival.hpp"

#include <gtest/gtest.h>

namespace revival_test {
namespace {

using namespace asap::fast;

constexpr LifeRule kRule{.mass_s = 0.03F,
                         .confirm_events = 14,
                         .die_events = 2,
                         .die_sigma = 2,
                         .birth_rate_hz = 300,
                         .confirm_evidence = 8,
                         .drop_evidence = 4,
                         .starve_ratio = 0.15F,
                         .velocity_decay_s = 0.1F,
                         .hide_s = 0.06F,
                         .coast_s = 0.25F,
                         .mature_s = 0.04F};

// One that went at 150 px/s from (100, 50) behind something 0.3 s ago.
struct Hidden {
  Tracks tracks{4};
  Tracks::Slot lost = tracks.create(110, 50, 0);

  Hidden() {
    tracks[lost].phase = Phase::kCoasting;
    Life& life = tracks.life(lost);
    life.seen_x = 100;
    life.seen_y = 50;
    life.usual_vx = 150;
    life.starved_s = 0.3F;
  }
  Tracks::Slot found_at(float x, float y) {
    const auto newborn = tracks.create(x, y, 0);
    tracks[newborn].phase = Phase::kConfirmed;
    const auto found = lost_track_of(tracks, newborn, 0, kRule);
    tracks.remove(newborn);
    return found;
  }
};

TEST(Revival, FindsItWhereItsVelocityHasCarriedIt) {
  Hidden hidden;
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);
  EXPECT_EQ(hidden.found_at(160, 60), hidden.lost);  // 12 + 0.35 * 45 = 27.8 px
  EXPECT_EQ(hidden.found_at(175, 50), Tracks::kNone);
  EXPECT_EQ(hidden.found_at(145, 80), Tracks::kNone);
  EXPECT_EQ(hidden.found_at(110, 50), Tracks::kNone);
}

TEST(Revival, AListedTrackIsNotLost) {
  Hidden hidden;
  hidden.tracks[hidden.lost].phase = Phase::kConfirmed;
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);  // starved, hence not listed
  hidden.tracks.life(hidden.lost).starved_s = 0;
  hidden.tracks.life(hidden.lost).seen_x = 145;
  EXPECT_EQ(hidden.found_at(145, 50), Tracks::kNone);
  hidden.tracks.life(hidden.lost).starved_s = 0.3F;
  hidden.tracks[hidden.lost].phase = Phase::kTentative;
  EXPECT_EQ(hidden.found_at(190, 50), Tracks::kNone);
}

TEST(Revival, TheNearestOfTwo) {
  Hidden hidden;
  const auto other = hidden.tracks.create(0, 0, 0);
  hidden.tracks[other].phase = Phase::kCoasting;
  hidden.tracks.life(other) = hidden.tracks.life(hidden.lost);
  hidden.tracks.life(other).seen_x = 110;
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);
  EXPECT_EQ(hidden.found_at(155, 50), other);
}

TEST(Revival, RemembersPositionAndUsualVelocity) {
  Track track;
  Life life;
  track.x = 5;
  track.vx = 100;
  for (int i = 1; i <= 1000; ++i) {
    remember_motion(track, life, Tick(static_cast<Stamp>(10'000), 0.002F, 0, kRule));
  }
  EXPECT_NEAR(life.seen_x, 6, 1e-4F);
  EXPECT_NEAR(life.usual_vx, 100, 0.1F);
}

TEST(Revival, WhoIsNotListedWaitsWhereItWasSeen) {
  Hidden hidden;
  Track& track = hidden.tracks[hidden.lost];
  Life& life = hidden.tracks.life(hidden.lost);
  track.vx = track.vy = 30;
  wait_where_seen(track, life);
  const Sight s = sight_of(track, 100'000, 100, 50);
  EXPECT_EQ(s.dx, 0);
  EXPECT_EQ(s.dy, 0);
  EXPECT_EQ(life.kalman.x, 100);
  EXPECT_EQ(life.kalman.y, 50);
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);
}

}  // namespace
}  // namespace revival_test
