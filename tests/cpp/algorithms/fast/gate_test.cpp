#include "algorithms/fast/gate.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace asap::fast::gate_test {
namespace {

constexpr GateRule kRule{.birth_radius_px = 18,
                         .min_radius_px = 7,
                         .max_radius_px = 40,
                         .scale = 2,
                         .padding_px = 2,
                         .circle_scale = 2,
                         .circle_padding_px = 5,
                         .noise_events = 30,
                         .least_density_hz = 1};
constexpr float kYoung_px = 18;

Track track_with(float sxx, float sxy, float syy) {
  Track track;
  track.sxx = sxx;
  track.sxy = sxy;
  track.syy = syy;
  return track;
}

float value_at(const Track& track, float x, float y) {
  return gate_value(track, innovation_of(track, track.stamp, x, y));
}

TEST(Gate, OfANewTrackIsACircle) {
  Track track;
  shape_birth_gate(track, kYoung_px);
  EXPECT_LE(value_at(track, 0, 17.9F), 1);
  EXPECT_GT(value_at(track, 13, 13), 1);
}

TEST(Gate, EllipseFollowsTheCovariance) {
  Track track = track_with(96, 0, 0);  // half-axes 2 sqrt(96 + 4) = 20 and 2 sqrt(4) = 4
  shape_gate(track, kRule, kRule.scale, kYoung_px, largest_variance(track), true, 0);
  EXPECT_NEAR(value_at(track, 20, 0), 1, 1e-4);
  EXPECT_LT(value_at(track, 19, 0), 1);
  EXPECT_GT(value_at(track, 21, 0), 1);
}

// A large track whose gate has half-axes of 20 and 4 px.
struct WithFragments {
  Track track = track_with(96, 0, 0);
  TrackState state;

  WithFragments() {
    state.extent_px = 10;
    shape();
  }
  void shape() {
    state.gate_scale = ellipse_scale(kRule, state, 0);
    shape_gate(track, kRule, state.gate_scale, 5, largest_variance(track), false, 0);
  }
  void add(float dx) {
    note_fragment(track, state, dx, 0);
    shape();
  }
};

TEST(Gate, ContainsTheFragmentsBesideALargeTrack) {
  WithFragments large;
  EXPECT_GT(value_at(large.track, 25, 0), 1);
  large.add(25);
  EXPECT_LT(value_at(large.track, 25, 0), 1);
  EXPECT_FLOAT_EQ(large.state.gate_scale, 1.1F * 2.5F);
  large.add(22);  // the other one is still there
  EXPECT_FLOAT_EQ(large.state.gate_scale, 1.1F * 2.5F);
  large.add(60);
  EXPECT_FLOAT_EQ(large.state.gate_scale, 2.8F);
}

TEST(Gate, ForgetsFragmentsAfter200Ms) {
  WithFragments large;
  large.add(25);
  large.state.fragment_s = 0.19F;
  large.shape();
  EXPECT_FLOAT_EQ(large.state.gate_scale, 1.1F * 2.5F);
  large.state.fragment_s = 0.21F;
  large.shape();
  EXPECT_FLOAT_EQ(large.state.gate_scale, 2);
  large.add(22);
  EXPECT_FLOAT_EQ(large.state.gate_scale, 1.1F * 2.2F);
}

TEST(Gate, IsNeverNarrowerForAFragment) {
  WithFragments large;
  large.add(10);
  EXPECT_FLOAT_EQ(large.state.gate_scale, 2);
}

TEST(Gate, IsNoWiderForASmallTrackOrInNoise) {
  WithFragments large;
  large.add(60);
  EXPECT_FLOAT_EQ(ellipse_scale(kRule, large.state, 0.1F), 2.8F);
  EXPECT_FLOAT_EQ(ellipse_scale(kRule, large.state, 0.15F), 2.4F);
  EXPECT_FLOAT_EQ(ellipse_scale(kRule, large.state, 0.2F), 2);
  EXPECT_FLOAT_EQ(ellipse_scale(kRule, large.state, 5), 2);
  large.state.extent_px = 8.4F;
  EXPECT_FLOAT_EQ(ellipse_scale(kRule, large.state, 0), 2);
}

// Arms of 40 px. 2.3 standard deviations leave the tips out.
TEST(Gate, HoldsTheTipsOfAnL) {
  GateRule rule = kRule;
  rule.scale = 2.3F;
  Track track = track_with(500.0F / 3, -100, 500.0F / 3);  // of the points of both arms
  const float variance = largest_variance(track);
  TrackState state;
  state.extent_px = std::sqrt(variance);
  state.gate_scale = rule.scale;
  shape_gate(track, rule, rule.scale, 5, variance, false, 0);
  EXPECT_GT(value_at(track, 30, -10), 1);
  note_fragment(track, state, 30, -10);
  shape_gate(track, rule, ellipse_scale(rule, state, 0), 5, variance, false, 0);
  EXPECT_LT(value_at(track, 30, -10), 1);
  EXPECT_LT(value_at(track, -10, 30), 1);
}

TEST(Gate, EllipseTurnsWithTheCovariance) {
  Track track = track_with(50, 45, 50);
  shape_gate(track, kRule, kRule.scale, kYoung_px, largest_variance(track), true, 0);
  EXPECT_LT(value_at(track, 13.5F, 13.5F), 1);
  EXPECT_GT(value_at(track, 13.5F, -13.5F), 1);
}

TEST(Gate, CircleFollowsTheExtentOnceMature) {
  Track track = track_with(4, 0, 4);  // circle: 2 * 2 + 5
  shape_gate(track, kRule, kRule.scale, kYoung_px, 4, true, 0);
  EXPECT_NEAR(value_at(track, 9, 0), 1, 1e-4);
  shape_gate(track, kRule, kRule.scale, kYoung_px, 4, false, 0);
  EXPECT_NEAR(value_at(track, 18, 0), 1, 1e-4);
  Track small = track_with(0.1F, 0, 0.1F);
  shape_gate(small,
             {.birth_radius_px = 18,
              .min_radius_px = 7,
              .max_radius_px = 40,
              .scale = 2,
              .padding_px = 0.1F,
              .circle_scale = 2,
              .circle_padding_px = 0.1F},
             2, kYoung_px, 0.1F, true, 0);
  EXPECT_NEAR(value_at(small, 7, 0), 1, 1e-4);
}

TEST(Gate, HasALongestAxis) {
  Track track = track_with(5000, 0, 100);
  shape_gate(track, kRule, kRule.scale, kYoung_px, 5000, true, 0);
  EXPECT_NEAR(value_at(track, 40, 0), 1, 1e-4);
}

TEST(Gate, PositionVarianceWidensIt) {
  Track track = track_with(96, 0, 96);
  shape_gate(track, kRule, kRule.scale, kYoung_px, 96, true, 125);  // half-axis 2 sqrt(225)
  EXPECT_NEAR(value_at(track, 30, 0), 1, 1e-4);
}

TEST(Gate, AWideCircleIsForYoungTracksOnly) {
  Track track = track_with(0, 0, 400);  // its own circle: 2 * 20 + 5; the ellipse is narrow along x
  shape_gate(track, kRule, kRule.scale, 25, 400, false, 0);
  EXPECT_NEAR(value_at(track, 25, 0), 1, 1e-4);
  shape_gate(track, kRule, kRule.scale, 25, 400, true, 0);
  EXPECT_NEAR(value_at(track, 18, 0), 1, 1e-4);
}

constexpr float kPi = 3.14159265F;

TEST(Gate, AreaIsThatOfTheEllipseButNoLessThanTheSmallestCircle) {
  EXPECT_NEAR(mature_gate_area(track_with(100, 0, 100), kRule), kPi * 400, 0.1);
  EXPECT_NEAR(mature_gate_area(track_with(1, 0, 1), kRule), kPi * 49, 0.1);
  EXPECT_NEAR(young_gate_area(18), kPi * 324, 0.1);
}

TEST(Gate, YoungTracksAreAsWideAsTheNoiseAllows) {
  constexpr float kMass_s = 0.03F;
  EXPECT_EQ(widest_radius(kRule, 0, kMass_s), 30);
  EXPECT_EQ(widest_radius(kRule, 10, kMass_s), 18);
  const float radius = widest_radius(kRule, 0.5F, kMass_s);
  EXPECT_GT(radius, 18);
  EXPECT_LT(radius, 30);
  EXPECT_NEAR(0.5F * kMass_s * kPi * radius * radius, kRule.noise_events, 1e-3);
}

TEST(Gate, ATrackOfFewEventsIsNoLargeObject) {
  TrackState state;
  state.near_confirmed = false;
  state.age_s = 0.002F;
  EXPECT_EQ(young_radius(state, kRule, 30), 30);  // not known yet
  state.age_s = 0.003F;
  EXPECT_EQ(young_radius(state, kRule, 30), 18);
  state.slow_rate_hz = 500;
  state.fast_rate_hz = 25 * 25 * kPi;  // an event per pixel and second
  EXPECT_NEAR(young_radius(state, kRule, 30), 25, 1e-3);
  state.slow_rate_hz = 1e5F;
  EXPECT_EQ(young_radius(state, kRule, 30), 30);
  state.near_confirmed = true;
  EXPECT_EQ(young_radius(state, kRule, 30), 18);
}

}  // namespace
}  // namespace asap::fast::gate_test
