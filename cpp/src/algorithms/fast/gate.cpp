#include "algorithms/fast/gate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace asap::inline v0_1::fast {

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

float ellipse_scale(const TrackState& state) noexcept {
  if (state.fragment_s > kFragment_s || state.extent_px < kLarge_px) return kGateScale;
  return std::max(kGateScale, state.fragment_scale);
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

}  // namespace asap::inline v0_1::fast
