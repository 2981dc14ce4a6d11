#include "algorithms/fast/kalman.hpp"

#include <algorithm>
#include <cmath>

namespace asap::inline v0_1::fast {

namespace {

constexpr float kTravel_extents = 2;  // way on which the centre's variance falls to 1/e
constexpr float kContactCentreVariance = 0.08F;
constexpr float kContact_s = 0.14F;
constexpr float kMinExtent_px = 1;

// px^2, of the mean, of whose events `fresh` are new.
float measurement_variance(const Track& track, float contour_variance, std::uint32_t fresh,
                           std::uint32_t mean_events) noexcept {
  const float w = track.mean_weight;
  const float spread =
      w * w * 0.5F * (track.sxx + track.syy) + (1 - w) * (1 - w) * 2 * contour_variance;
  const auto memory = static_cast<float>(mean_events);
  const float share = std::min(1.0F, static_cast<float>(fresh) / memory);
  return std::max(kMinMeasurement_px2, kMeasurementScale * spread / (memory * share));
}

float acceleration_density(const Track& track) noexcept {
  if (track.partners > 0) return kContactAcceleration_px2_s3;
  const float speed2 = track.vx * track.vx + track.vy * track.vy;
  return std::min(kMaxAcceleration_px2_s3,
                  kAcceleration_px2_s3 + kAccelerationPerSpeed_px * speed2 * std::sqrt(speed2));
}

// Propagates the covariance over dt, s.
void predict(KalmanState& state, float dt, float q) noexcept {
  state.pxx += 2 * dt * state.pxv + dt * dt * state.pvv + q * dt * dt * dt / 3;
  state.pxv += dt * state.pvv + q * dt * dt / 2;
  state.pvv += q * dt;
}

// px^2, of the position along each axis, predicted for `now`.
float position_variance(const Track& track, const KalmanState& state, Stamp now) noexcept {
  KalmanState then = state;
  predict(then, std::max(0.0F, age_s(now, state.stamp)), acceleration_density(track));
  return then.pxx;
}

}  // namespace

void kalman_update(Track& track, KalmanState& state, float contour_variance,
                   std::uint32_t mean_events) noexcept {
  const std::uint32_t fresh = track.events - state.events;
  if (fresh < kKalmanEvents) return;
  const float dt = std::max(0.0F, age_s(track.stamp, state.stamp));
  state.x += track.vx * dt;
  state.y += track.vy * dt;
  predict(state, dt, acceleration_density(track));

  const float s = state.pxx + measurement_variance(track, contour_variance, fresh, mean_events);
  const float kx = state.pxx / s;
  const float kv = state.pxv / s;
  const float ex = track.x - state.x;
  const float ey = track.y - state.y;
  state.x += kx * ex;
  state.y += kx * ey;
  track.vx += kv * ex;
  track.vy += kv * ey;
  state.pvv -= kv * state.pxv;
  state.pxv *= 1 - kx;
  state.pxx *= 1 - kx;
  state.stamp = track.stamp;
  state.events = track.events;
}

void kalman_without_events(Track& track, KalmanState& state, Stamp now) noexcept {
  const auto moved_s = [&](Stamp then) {
    return kVelocityDecay_s * (1 - decay(std::max(0.0F, age_s(now, then)) / kVelocityDecay_s));
  };
  const float mean_s = moved_s(track.stamp);
  const float state_s = moved_s(state.stamp);
  track.x += track.vx * mean_s;
  track.y += track.vy * mean_s;
  state.x += track.vx * state_s;
  state.y += track.vy * state_s;

  const float dt = std::max(0.0F, age_s(now, state.stamp));
  state.pxx = std::min(kMaxVariance_px2, state.pxx + 2 * dt * state.pxv + dt * dt * state.pvv);
  state.pxv += dt * state.pvv;
  // pxx pvv >= pxv^2 keeps the matrix a covariance.
  state.pxv = std::min(state.pxv, std::sqrt(state.pxx * state.pvv));
  const float slower = 1 - state_s / kVelocityDecay_s;
  track.vx *= slower;
  track.vy *= slower;
  track.stamp = now;
  state.stamp = now;
}

void update_centre_variance(const Track& track, TrackState& state, float dt_s) noexcept {
  const bool in_contact = track.partners > 0;
  const float travel_extents =
      length(track.vx, track.vy) * dt_s / std::max(kMinExtent_px, state.extent_px);
  const float left = decay(in_contact ? dt_s / kContact_s : travel_extents / kTravel_extents);
  const float end = in_contact ? kContactCentreVariance : kMinCentreVariance;
  state.centre_variance = end + (state.centre_variance - end) * left;
}

PositionError position_error(const Track& track, const TrackState& state, Stamp now) noexcept {
  const float variance = position_variance(track, state.kalman, now);
  return {variance + state.centre_variance * track.sxx, state.centre_variance * track.sxy,
          variance + state.centre_variance * track.syy};
}

}  // namespace asap::inline v0_1::fast
