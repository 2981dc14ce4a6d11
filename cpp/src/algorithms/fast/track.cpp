#include "algorithms/fast/track.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace asap::fast {

// ---- contour -----------------------------------------------------------------------------------

// Bins are centred on the axes and diagonals, where most whole pixels lie, so none is on a border.
DirectionTable::DirectionTable() : bins_{} {
  constexpr double kBin_rad = 2 * std::numbers::pi / kContourBins;
  for (int dy = -kReach; dy < kReach; ++dy) {
    for (int dx = -kReach; dx < kReach; ++dx) {
      const double bins = std::atan2(dy, dx) / kBin_rad + kContourBins;
      const auto bin = static_cast<std::size_t>(std::floor(bins + 0.5)) % kContourBins;
      bins_[static_cast<std::size_t>(dy + kReach) * kSide + static_cast<std::size_t>(dx + kReach)] =
          static_cast<std::uint8_t>(bin);
    }
  }
}

// ---- gate --------------------------------------------------------------------------------------

namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kFragment_s = 0.2F;  // time for which a fragment is remembered

}  // namespace

float largest_variance(const Track& track) noexcept {
  const float half_sum = 0.5F * (track.sxx + track.syy);
  const float half_difference = 0.5F * (track.sxx - track.syy);
  return half_sum + std::sqrt(half_difference * half_difference + track.sxy * track.sxy);
}

void note_fragment(const Track& track, TrackState& state, float dx, float dy) noexcept {
  constexpr float kMargin = 1.1F;
  constexpr float kWidest = 2.8F;  // standard deviations
  const float gate = gate_value(track, {.mean_x = 0, .mean_y = 0, .dx = dx, .dy = dy});
  const float reaching = kMargin * state.gate_scale * std::sqrt(gate);
  const float before = state.fragment_s > kFragment_s ? 0 : state.fragment_scale;
  state.fragment_scale = std::min(kWidest, std::max(before, reaching));
  state.fragment_s = 0;
}

float ellipse_scale(const TrackState& state, float noise_share) noexcept {
  constexpr float kRareNoise = 0.1F;
  if (state.fragment_s > kFragment_s || state.extent_px < kLarge_px) return kGateScale;
  const float rarity = std::clamp(2 - noise_share / kRareNoise, 0.0F, 1.0F);
  return kGateScale + rarity * std::max(0.0F, state.fragment_scale - kGateScale);
}

float widest_radius(const GateRule& rule, float noise_hz) noexcept {
  constexpr float kMinNoise_hz = 1e-6F;
  const float noise = std::max(kMinNoise_hz, noise_hz) * kMass_s;
  return std::clamp(std::sqrt(rule.noise_events / (kPi * noise)), rule.birth_radius_px,
                    kWidestBirth * rule.birth_radius_px);
}

float young_radius(const TrackState& state, const GateRule& rule, float widest_px) noexcept {
  constexpr float kUnknown_s = 0.003F;  // an age at which the rates say nothing
  if (state.near_confirmed) return rule.birth_radius_px;
  if (state.age_s < kUnknown_s) return widest_px;
  const float rate_hz = std::max(state.fast_rate_hz, state.slow_rate_hz);
  return std::clamp(std::sqrt(rate_hz / (kPi * rule.min_density_hz)), rule.birth_radius_px,
                    widest_px);
}

void shape_birth_gate(Track& track, float radius_px) noexcept {
  constexpr float kNothing = 1e6F;  // an ellipse that contains no pixel but the centre
  track.inverse_circle2 = 1 / (radius_px * radius_px);
  track.qa = kNothing;
  track.qb = 0;
  track.qc = kNothing;
}

void shape_gate(Track& track, const GateRule& rule, float scale, float young_px,
                float largest_variance_px2, bool mature, float position_variance_px2) noexcept {
  const float own = kCircleScale * std::sqrt(largest_variance_px2) + kCirclePadding_px;
  const float radius =
      mature ? std::max(kMinRadius_px, std::min(own, rule.birth_radius_px)) : young_px;
  track.inverse_circle2 = 1 / (radius * radius);

  const float padding = kGatePadding_px * kGatePadding_px + position_variance_px2;
  const float a = track.sxx + padding;
  const float b = track.sxy;
  const float c = track.syy + padding;
  const float scale2 = scale * scale;
  const float longest2 = scale2 * (largest_variance_px2 + padding);
  const float max2 = rule.max_radius_px * rule.max_radius_px;
  const float shrink = std::max(1.0F, longest2 / max2);
  const float factor = shrink / (scale2 * (a * c - b * b));
  track.qa = c * factor;
  track.qb = -b * factor;
  track.qc = a * factor;
}

float young_gate_area(float radius_px) noexcept { return kPi * radius_px * radius_px; }

float mature_gate_area(const Track& track) noexcept {
  const float determinant = std::max(0.0F, track.sxx * track.syy - track.sxy * track.sxy);
  return kPi *
         std::max(kMinRadius_px * kMinRadius_px, kGateScale * kGateScale * std::sqrt(determinant));
}

// ---- Kalman filter -----------------------------------------------------------------------------

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

void update_centre_variance(Contour& contour, const Track& track, float extent_px,
                            float dt_s) noexcept {
  const bool in_contact = track.partners > 0;
  const float travel_extents =
      length(track.vx, track.vy) * dt_s / std::max(kMinExtent_px, extent_px);
  const float left = decay(in_contact ? dt_s / kContact_s : travel_extents / kTravel_extents);
  const float end = in_contact ? kContactCentreVariance : kMinCentreVariance;
  contour.centre_variance = end + (contour.centre_variance - end) * left;
}

PositionError position_error(const Track& track, const KalmanState& state, const Contour& contour,
                             Stamp now) noexcept {
  const float variance = position_variance(track, state, now);
  return {variance + contour.centre_variance * track.sxx, contour.centre_variance * track.sxy,
          variance + contour.centre_variance * track.syy};
}

}  // namespace asap::fast
