#include "algorithms/fast/kalman.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace asap::fast::kalman_test {
namespace {

constexpr KalmanRule kRule{.acceleration = 5e3F,
                           .per_speed3 = 0.055F,
                           .most = 1e7F,
                           .contact = 5e3F,
                           .measurement_scale = 4,
                           .min_measurement_px2 = 0.05F,
                           .mean_events = 60};

// A track that moves at vx and is measured every 2 ms, for a second, with 40 events in between.
Track followed(float vx, KalmanState& state) {
  Track track;
  track.sxx = track.syy = 25;
  track.mean_weight = 0.2F;
  for (int step = 0; step < 500; ++step) {
    track.stamp = static_cast<Stamp>(2000 * step);
    track.x = vx * 2e-3F * static_cast<float>(step) + (step % 2 == 0 ? 0.05F : -0.05F);
    track.events += 40;
    kalman_update(track, state, 0.3F, kRule);
  }
  return track;
}

TEST(Kalman, FindsTheVelocity) {
  for (const float vx : {0.0F, 50.0F, -400.0F}) {
    KalmanState state;
    const Track track = followed(vx, state);
    EXPECT_NEAR(track.vx, vx, 3 + 0.02F * std::abs(vx));
    EXPECT_NEAR(track.vy, 0, 1e-3F);
    EXPECT_NEAR(state.x, track.x, 0.2F);
    EXPECT_GT(state.pvv, 0);
    EXPECT_GE(state.pxx * state.pvv, state.pxv * state.pxv);
  }
}

TEST(Kalman, AMeanOfFewerEventsIsTrustedLess) {
  const auto correction = [](std::uint32_t mean_events) {
    Track track;
    track.sxx = track.syy = 25;
    track.x = 1;
    track.events = 100;
    KalmanState state;
    state.pxx = 0.5F;
    kalman_update(track, state, 0.3F, kRule, mean_events);
    return state.x;
  };
  EXPECT_LT(correction(10), 0.5F * correction(60));
  EXPECT_EQ(correction(60), correction(1000));
}

TEST(Kalman, PredictionsAreLessCertain) {
  KalmanState state;
  const Track track = followed(100, state);
  const KalmanState before = state;
  const auto variance = [&](Stamp ahead_us) {
    return position_variance(track, state, state.stamp + ahead_us, kRule);
  };
  EXPECT_EQ(variance(0), state.pxx);
  const float dt = 0.02F;
  const float q = kRule.acceleration + kRule.per_speed3 * 1e6F;
  const float grown = state.pxx + 2 * dt * state.pxv + dt * dt * state.pvv + q * dt * dt * dt / 3;
  EXPECT_NEAR(variance(20'000), grown, 0.02F * grown);
  EXPECT_EQ(variance(static_cast<Stamp>(-5000)), state.pxx);  // never the past
  EXPECT_EQ(state.pvv, before.pvv);
}

TEST(Kalman, AFastTrackIsFollowedMoreCloselyThanASlowOne) {
  KalmanState slow;
  KalmanState fast;
  followed(10, slow);
  followed(400, fast);
  EXPECT_GT(fast.pvv, 10 * slow.pvv);
}

TEST(Kalman, InContactTheAccelerationIsTheOneOfContact) {
  KalmanState state;
  Track track = followed(400, state);
  KalmanState touching = state;
  Track partner = track;
  partner.partners = 1;
  for (Track* t : {&track, &partner}) {
    t->stamp += 2000;
    t->events += 40;
  }
  kalman_update(track, state, 0.3F, kRule);
  kalman_update(partner, touching, 0.3F, kRule);
  EXPECT_LT(touching.pvv, state.pvv);
}

TEST(Kalman, WaitsForEightEvents) {
  Track track;
  KalmanState state;
  track.x = 5;
  track.events = 7;
  kalman_update(track, state, 1, kRule);
  EXPECT_EQ(state.x, 0);
  track.events = 8;
  kalman_update(track, state, 1, kRule);
  EXPECT_GT(state.x, 1);
  EXPECT_EQ(state.events, 8U);
}

TEST(Kalman, FewEventsCountLess) {
  const auto moved = [](std::uint32_t events) {
    Track track;
    track.sxx = track.syy = 100;
    track.x = 5;
    track.events = events;
    KalmanState state;
    kalman_update(track, state, 1, kRule);
    return state.x;
  };
  EXPECT_LT(moved(8), moved(60));
  EXPECT_EQ(moved(60), moved(1000));
}

// However it is cut into ticks, a starved track comes to rest after velocity * decay time.
TEST(Kalman, AStarvedTrackComesToRest) {
  for (const int ticks : {1, 10, 1000}) {
    Track track;
    KalmanState state;
    track.vx = 200;
    for (int i = 1; i <= ticks; ++i) {
      kalman_without_events(track, state, static_cast<Stamp>(1'000'000 / ticks * i), 0.1F);
    }
    EXPECT_NEAR(track.x, 20, 0.1F) << ticks;
    EXPECT_NEAR(state.x, 20, 0.1F) << ticks;
    EXPECT_LT(track.vx, 0.1F);
    EXPECT_EQ(track.stamp, 1'000'000U);
    EXPECT_LE(state.pxx, kMaxVariance_px2);
    EXPECT_GE(state.pxx * state.pvv * 1.001F, state.pxv * state.pxv);
  }
}

// ---- the error of the outline's centre ----

constexpr float kExtent_px = 5;

float centre_variance_after(float speed, float time_s, std::uint8_t partners = 0,
                            float first = Contour::kInitialCentreVariance) {
  Contour contour;
  contour.centre_variance = first;
  Track track;
  track.vy = -speed;
  track.partners = partners;
  for (float t = 0; t < time_s; t += 0.002F)
    update_centre_variance(contour, track, kExtent_px, 0.002F);
  return contour.centre_variance;
}

TEST(PositionError, CentreVarianceFallsWithTravel) {
  EXPECT_EQ(centre_variance_after(0, 1), Contour::kInitialCentreVariance);
  // 10 px are two extents.
  const float once =
      kMinCentreVariance + (Contour::kInitialCentreVariance - kMinCentreVariance) * std::exp(-1.0F);
  EXPECT_NEAR(centre_variance_after(100, 0.1F), once, 1e-3F);
  EXPECT_NEAR(centre_variance_after(50, 0.2F), once, 1e-3F);
  EXPECT_NEAR(centre_variance_after(400, 1), kMinCentreVariance, 1e-6F);
}

TEST(PositionError, CentreVarianceGrowsInContact) {
  const float soon = centre_variance_after(100, 0.05F, 1, kMinCentreVariance);
  const float late = centre_variance_after(100, 1, 1, kMinCentreVariance);
  EXPECT_GT(soon, 10 * kMinCentreVariance);
  EXPECT_GT(late, 2 * soon);
  EXPECT_EQ(centre_variance_after(0, 0.05F, 2, kMinCentreVariance), soon);
}

TEST(PositionError, APointHasACentreVarianceToo) {
  Contour contour;
  Track track;
  track.vx = 100;
  update_centre_variance(contour, track, 0, 0.002F);
  EXPECT_LT(contour.centre_variance, Contour::kInitialCentreVariance);
  EXPECT_GT(contour.centre_variance, 0.8F * Contour::kInitialCentreVariance);
}

TEST(PositionError, IsTheFiltersAndAShareOfTheEventsCovariance) {
  Track track;
  track.sxx = 40;
  track.sxy = -10;
  track.syy = 20;
  KalmanState state;
  state.pxx = 0.3F;
  state.stamp = 1000;
  Contour contour;
  contour.centre_variance = 0.01F;
  const PositionError error = position_error(track, state, contour, 1000, kRule);
  EXPECT_FLOAT_EQ(error.xx, 0.7F);
  EXPECT_FLOAT_EQ(error.xy, -0.1F);
  EXPECT_FLOAT_EQ(error.yy, 0.5F);
  EXPECT_GT(position_error(track, state, contour, 21'000, kRule).xx, error.xx);
}

}  // namespace
}  // namespace asap::fast::kalman_test
