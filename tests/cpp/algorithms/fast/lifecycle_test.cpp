#include "algorithms/fast/lifecycle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

namespace asap::fast::lifecycle_test {
namespace {

// ---- birth ----

TEST(BirthGrid, CountsWithDecay) {
  const CellMap map(40, 40, 4);
  BirthGrid grid(map, 0.015F);
  grid.clear(0);
  const std::size_t cell = map.cell(20, 20);
  EXPECT_EQ(grid.count(cell, 0), 1);
  EXPECT_EQ(grid.count(cell, 0), 2);
  EXPECT_NEAR(grid.count(cell, 15'000), 1 + 2 * std::exp(-1.0), 1e-4);
}

TEST(BirthGrid, NeighboursFadeLinearlyInTwoTimeConstants) {
  const CellMap map(40, 40, 4);
  BirthGrid grid(map, 0.015F);
  grid.clear(0);
  grid.count(map.cell(16, 16), 0);
  EXPECT_NEAR(grid.count(map.cell(20, 20), 15'000), 1 + 0.5, 1e-5);
  EXPECT_NEAR(grid.count(map.cell(12, 12), 30'000), 1, 1e-5);
  EXPECT_NEAR(grid.count(map.cell(36, 36), 15'000), 1, 1e-5);  // no neighbour
}

TEST(BirthGrid, ForgetsACellAndItsNeighbours) {
  const CellMap map(40, 40, 4);
  BirthGrid grid(map, 0.015F);
  grid.clear(0);
  grid.count(map.cell(16, 16), 0);
  grid.count(map.cell(20, 20), 0);
  grid.forget(map.cell(20, 20));
  EXPECT_EQ(grid.count(map.cell(20, 20), 0), 1);
}

// ---- confirmation, starvation, coasting, deletion ----

constexpr GateRule kGate{.birth_radius_px = 18,
                         .min_radius_px = 7,
                         .max_radius_px = 40,
                         .scale = 2.3F,
                         .padding_px = 2,
                         .circle_scale = 2.2F,
                         .circle_padding_px = 5};

constexpr LifecycleRule kRule{.mass_s = 0.03F,
                              .confirm_events = 14,
                              .die_events = 2,
                              .die_sigma = 2,
                              .birth_rate_hz = 300,
                              .confirm_evidence = 8,
                              .drop_evidence = 4,
                              .starve_ratio = 0.15F,
                              .velocity_decay_s = 0.1F,
                              .hide_s = 0.06F,
                              .coast_s = 0.2F,
                              .mature_s = 0.04F};

struct Object {
  Track track{};
  TrackState state{};
  float now_s = 0;

  Object() {
    track.phase = Phase::kTentative;
    state.young_radius_px = 18;
    state.extent_px = 5;
    state.near_confirmed = false;
  }

  // One tick with this many events.
  Assessment tick(std::uint32_t events, float dt_s = 0.002F, float noise_hz = 0) {
    now_s += dt_s;
    const auto now = static_cast<Stamp>(1e6F * now_s);
    track.events += events;
    if (events > 0) track.stamp = now;
    const Assessment assessment =
        assess(track, state, Tick(now, dt_s, noise_hz, kRule), kRule, kGate);
    if (assessment == Assessment::kConfirm) track.phase = Phase::kConfirmed;
    return assessment;
  }
  // Time until that assessment, s, or -1.
  float until(Assessment assessment, std::uint32_t events, float limit_s, float noise_hz = 0) {
    for (float t = 0.002F; t < limit_s; t += 0.002F) {
      if (tick(events, 0.002F, noise_hz) == assessment) return t;
    }
    return -1;
  }
};

TEST(Lifecycle, ConfirmsWhatHasEnoughEvents) {
  Object busy;
  EXPECT_NEAR(busy.until(Assessment::kConfirm, 10, 0.1F), 0.004F, 1e-3F);
  EXPECT_EQ(busy.track.phase, Phase::kConfirmed);
  Object quiet;
  EXPECT_EQ(quiet.until(Assessment::kConfirm, 0, 0.5F), -1);
}

TEST(Lifecycle, ASmallObjectNeedsFewerEvents) {
  Object small;
  small.state.extent_px = 3.9F;
  EXPECT_EQ(small.tick(7), Assessment::kKeep);
  EXPECT_EQ(small.tick(2), Assessment::kConfirm);  // some of the mass has decayed
  Object large;
  large.state.extent_px = 4;
  EXPECT_EQ(large.tick(13), Assessment::kKeep);
  EXPECT_EQ(large.tick(0), Assessment::kKeep);
  EXPECT_EQ(large.tick(3), Assessment::kConfirm);
}

TEST(Lifecycle, ATentativeTrackIsDeletedInTime) {
  Object quiet;
  quiet.tick(5);
  // 5 ln 51 of evidence, less 300 a second, falls to -4.
  EXPECT_NEAR(quiet.until(Assessment::kDelete, 0, 1), 0.079F, 0.005F);
}

TEST(Lifecycle, NoiseRaisesTheThreshold) {
  // 10 Hz on the thousand pixels of a new track's gate: 300 events in 30 ms would be noise.
  Object object;
  EXPECT_EQ(object.until(Assessment::kConfirm, 18, 0.14F, 10), -1);
  Object brighter;
  EXPECT_GT(brighter.until(Assessment::kConfirm, 60, 0.14F, 10), 0);
}

TEST(Lifecycle, ATentativeTrackNearAConfirmedOneWaits) {
  Object object;
  object.state.near_confirmed = true;
  EXPECT_NEAR(object.until(Assessment::kConfirm, 10, 0.1F), 0.03F, 0.0035F);
}

TEST(Lifecycle, APossibleFragmentIsNotConfirmed) {
  Object object;
  object.state.may_be_fragment = true;
  EXPECT_EQ(object.until(Assessment::kConfirm, 10, 0.1F), -1);
  object.state.may_be_fragment = false;
  EXPECT_EQ(object.tick(10), Assessment::kConfirm);
}

TEST(Lifecycle, AStoppedTrackIsHiddenThenCoastsThenDeleted) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  ASSERT_TRUE(is_listed(object.track, object.state, kRule));
  float hidden = 0;
  float coasting = 0;
  float deleted = 0;
  for (float t = 0.002F; t < 1 && deleted == 0; t += 0.002F) {
    const Assessment assessment = object.tick(0);
    if (hidden == 0 && !is_listed(object.track, object.state, kRule)) hidden = t;
    if (coasting == 0 && object.track.phase == Phase::kCoasting) coasting = t;
    if (assessment == Assessment::kDelete) deleted = t;
  }
  EXPECT_NEAR(hidden, 0.016F + 0.06F, 0.01F);  // starved once the fast rate is below 15 %
  EXPECT_NEAR(coasting, 0.03F * 5, 0.01F);     // a mass of 300 falls to 2
  EXPECT_NEAR(deleted, coasting + 0.2F, 0.005F);
}

TEST(Lifecycle, ACoastingTrackIsConfirmedAgain) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  for (int i = 0; i < 100; ++i) object.tick(0);
  ASSERT_EQ(object.track.phase, Phase::kCoasting);
  object.tick(20);
  EXPECT_EQ(object.track.phase, Phase::kConfirmed);
  EXPECT_TRUE(is_listed(object.track, object.state, kRule));
}

TEST(Lifecycle, OneLateTickCountsAsManyTicks) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  Object survivor = object;
  EXPECT_EQ(survivor.tick(0, 0.3F), Assessment::kKeep);
  EXPECT_EQ(survivor.track.phase, Phase::kCoasting);
  EXPECT_FALSE(is_listed(survivor.track, survivor.state, kRule));
  EXPECT_EQ(object.tick(0, 0.45F), Assessment::kDelete);
}

TEST(Lifecycle, TheSlowRateIsFrozenWhileStarved) {
  Object object;
  for (int i = 0; i < 200; ++i) object.tick(20);
  const float average = object.state.slow_rate_hz;
  EXPECT_NEAR(average, 10'000, 200);
  for (int i = 0; i < 50; ++i) object.tick(0);
  EXPECT_GT(object.state.slow_rate_hz, 0.7F * average);
  EXPECT_TRUE(is_starved(object.state));
  object.tick(20);
  object.tick(20);
  EXPECT_FALSE(is_starved(object.state));
}

TEST(Lifecycle, AScheduledDeletionHappens) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  schedule_deletion(object.track, object.state);
  EXPECT_FALSE(is_listed(object.track, object.state, kRule));
  EXPECT_EQ(object.tick(20), Assessment::kDelete);
}

TEST(Lifecycle, RecordsTheLastEvent) {
  Object object;
  object.tick(20);
  object.tick(0);
  EXPECT_EQ(object.state.last_event, 2000U);
}

TEST(Lifecycle, TheAverageExtentIsTheMeanAtFirst) {
  TrackState state;
  state.age_s = 0.002F;
  const Tick tick(0, 0.002F, 0, kRule);
  record_extent(state, 40, tick);
  EXPECT_FLOAT_EQ(state.average_extent2, 40);
  state.age_s = 0.008F;
  record_extent(state, 60, tick);
  EXPECT_FLOAT_EQ(state.average_extent2, 45);
}

TEST(Frame, IsLeftByTracksFarOutside) {
  const auto left = [](float x, float y, float vx = 0) {
    Track track;
    track.x = x;
    track.y = y;
    track.vx = vx;
    return has_left(track, 100'000, {.width = 20, .height = 10});
  };
  for (const auto& [x, y] : {std::pair{-3.0F, 5.0F}, {22.0F, 5.0F}, {5.0F, -3.0F}, {5.0F, 12.0F}}) {
    EXPECT_FALSE(left(x, y)) << x;
  }
  for (const auto& [x, y] : {std::pair{-3.1F, 5.0F}, {22.1F, 5.0F}, {5.0F, -3.1F}, {5.0F, 12.1F}}) {
    EXPECT_TRUE(left(x, y)) << x;
  }
  EXPECT_TRUE(left(15, 5, 80));  // by now
  EXPECT_TRUE(left(std::numeric_limits<float>::quiet_NaN(), 5));
}

// ---- re-identification ----

// A track at 150 px/s that was occluded at (100, 50) 0.3 s ago.
struct Hidden {
  Tracks tracks{4};
  Tracks::Slot lost = tracks.create(110, 50, 0);

  Hidden() {
    tracks[lost].phase = Phase::kCoasting;
    TrackState& state = tracks.state(lost);
    state.last_seen_x = 100;
    state.last_seen_y = 50;
    state.average_vx = 150;
    state.starved_s = 0.3F;
  }
  Tracks::Slot found_at(float x, float y) {
    const auto confirmed = tracks.create(x, y, 0);
    tracks[confirmed].phase = Phase::kConfirmed;
    const auto found = find_lost_track(tracks, confirmed, 0, kRule);
    tracks.remove(confirmed);
    return found;
  }
};

TEST(Reidentification, FollowsTheAverageVelocity) {
  Hidden hidden;
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);
  EXPECT_EQ(hidden.found_at(160, 60), hidden.lost);  // 12 + 0.35 * 45 = 27.8 px
  EXPECT_EQ(hidden.found_at(175, 50), Tracks::kNone);
  EXPECT_EQ(hidden.found_at(145, 80), Tracks::kNone);
  EXPECT_EQ(hidden.found_at(110, 50), Tracks::kNone);
}

TEST(Reidentification, AListedTrackIsNotLost) {
  Hidden hidden;
  hidden.tracks[hidden.lost].phase = Phase::kConfirmed;
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);  // starved, hence not listed
  hidden.tracks.state(hidden.lost).starved_s = 0;
  hidden.tracks.state(hidden.lost).last_seen_x = 145;
  EXPECT_EQ(hidden.found_at(145, 50), Tracks::kNone);
  hidden.tracks.state(hidden.lost).starved_s = 0.3F;
  hidden.tracks[hidden.lost].phase = Phase::kTentative;
  EXPECT_EQ(hidden.found_at(190, 50), Tracks::kNone);
}

TEST(Reidentification, PrefersTheNearestOfTwo) {
  Hidden hidden;
  const auto other = hidden.tracks.create(0, 0, 0);
  hidden.tracks[other].phase = Phase::kCoasting;
  hidden.tracks.state(other) = hidden.tracks.state(hidden.lost);
  hidden.tracks.state(other).last_seen_x = 110;
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);
  EXPECT_EQ(hidden.found_at(155, 50), other);
}

TEST(Reidentification, RecordsPositionAndAverageVelocity) {
  Track track;
  TrackState state;
  track.x = 5;
  track.vx = 100;
  for (int i = 1; i <= 1000; ++i) {
    record_motion(track, state, Tick(static_cast<Stamp>(10'000), 0.002F, 0, kRule));
  }
  EXPECT_NEAR(state.last_seen_x, 6, 1e-4F);
  EXPECT_NEAR(state.average_vx, 100, 0.1F);
}

TEST(Reidentification, AnUnlistedTrackReturnsToWhereItWasSeen) {
  Hidden hidden;
  Track& track = hidden.tracks[hidden.lost];
  TrackState& state = hidden.tracks.state(hidden.lost);
  track.vx = track.vy = 30;
  return_to_last_seen(track, state);
  const Point mean = predicted_mean(track, 100'000);
  EXPECT_EQ(mean.x, 100);
  EXPECT_EQ(mean.y, 50);
  EXPECT_EQ(state.kalman.x, 100);
  EXPECT_EQ(state.kalman.y, 50);
  EXPECT_EQ(hidden.found_at(145, 50), hidden.lost);
}

}  // namespace
}  // namespace asap::fast::lifecycle_test
