// How a track takes an event: exponential mean and covariance with a memory in events. Once the
// outline is known, the innovation is blended with twice the radial residual, because edges fire
// unevenly and the plain mean wobbles with them. Where noise is common, events far from the outline
// do not count. In contact, covariance and contour are frozen, because each track would learn the
// other's edges. One thread, per event. Inline, O(1), no allocation.
// Source: own design.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

struct UpdateRule {
  std::uint32_t mean_events = 0;   // memory of the mean; less with gamma
  std::uint32_t contour_mask = 0;  // the contour learns events whose number has none of these bits
  float far_weight = 1;            // weight of events far from the outline

  // px by which an event may push a side once there are others: noise must not carry it away.
  float side_growth() const noexcept { return 0.5F + far_weight; }
};

// The weight of events far from the outline. If noise is rare, they belong to the object, whose
// outline is not exact or whose motion changes. noise_hz: per pixel, of what reaches the tracks.
inline float far_weight(float noise_hz) noexcept {
  constexpr float kRare_hz = 0.1F;
  constexpr float kCommon_hz = 0.5F;
  return std::clamp((kCommon_hz - noise_hz) / (kCommon_hz - kRare_hz), 0.0F, 1.0F);
}

// The memory of the mean of an object of this size: a small one moves by its own size in the time
// in which a large one has the events to average over.
inline std::uint32_t size_memory(const Track& track, const UpdateRule& rule) noexcept {
  constexpr float kPerVariance = 1.5F;  // events per px^2
  constexpr std::uint32_t kShortest = 10;
  const auto events = static_cast<std::uint32_t>(
      std::min(kPerVariance * (track.sxx + track.syy), static_cast<float>(rule.mean_events)));
  return std::max(std::min(kShortest, rule.mean_events), events);
}

// The weight of the plain mean, by inverse variances. Textured objects, whose events fill their
// outline, fall back to the plain mean.
inline float mean_weight(const Track& track, const Contour& contour) noexcept {
  const float scatter = 2 * kMeanWeightScale * contour.variance;
  const float spread = 0.5F * (track.sxx + track.syy) + 0.5F;
  return std::clamp(scatter / (scatter + spread), kMinMeanWeight, 1.0F);
}

// The weight of an event by its distance from the outline: 1 up to 3 px, `far` from 6 px on.
inline float event_weight(float residual, float far) noexcept {
  constexpr float kNone_px = 6;
  constexpr float kFade_px = 3;
  return std::clamp((kNone_px - std::abs(residual)) * (1 / kFade_px), far, 1.0F);
}

// Takes an event without contact.
inline void update_mean(Track& track, Contour& contour, const Innovation& nu, Stamp now, bool on,
                        const UpdateRule& rule, const DirectionTable& directions) noexcept {
  constexpr float kAnywhere_px = 1000;
  constexpr float kNear_px = 3;  // where the weight of an event is 1 and nothing is clipped
  constexpr std::uint32_t kSampleMask = 15;
  const std::uint32_t n = ++track.events;
  float gain = contour.least_gain;
  float spread_gain = 1.0F / kCovarianceEvents;
  if (n < kCovarianceEvents) [[unlikely]] {
    spread_gain = 1 / static_cast<float>(n);
    gain = std::max(gain, spread_gain);
  }
  const float distance = length(nu.dx, nu.dy);
  const std::size_t bin = directions.bin(nu.dx, nu.dy, distance);
  contour.learn_polarity(on, nu.dx, nu.dy, gain);
  if (!contour.holds(nu.dx, nu.dy)) [[unlikely]] {
    contour.push_sides(nu.dx, nu.dy, n < kMeanEvents ? kAnywhere_px : rule.side_growth());
  }

  const float residual = contour.residual(bin, distance);
  if ((n & rule.contour_mask) == 0) {
    contour.learn(bin, distance);
    if ((n & kSampleMask) == 0) contour.sample_polarity();
  }
  float step = gain;
  if (n >= rule.mean_events && contour.known(bin) && distance > 0) {
    float clipped = residual;
    float weight = 1;
    if (std::abs(residual) > kNear_px) {
      clipped = Contour::clip(residual);
      weight = event_weight(residual, rule.far_weight);
    }
    step *= (track.mean_weight + contour.outline_weight * clipped / distance) * weight;
  }
  track.x = nu.mean_x + step * nu.dx;
  track.y = nu.mean_y + step * nu.dy;
  track.stamp = now;
  track.sxx += spread_gain * ((1 - gain) * nu.dx * nu.dx - track.sxx);
  track.sxy += spread_gain * ((1 - gain) * nu.dx * nu.dy - track.sxy);
  track.syy += spread_gain * ((1 - gain) * nu.dy * nu.dy - track.syy);
}

// Takes an event in contact: moves the mean alone, by the outline's residual.
inline void update_in_contact(Track& track, Contour& contour, const Innovation& nu, Stamp now,
                              bool on, const UpdateRule& rule,
                              const DirectionTable& directions) noexcept {
  const float n = 1 + static_cast<float>(track.events++);
  const float gain = 1 / std::min(n, static_cast<float>(rule.mean_events));
  const float distance = length(nu.dx, nu.dy);
  const std::size_t bin = directions.bin(nu.dx, nu.dy, distance);
  contour.learn_polarity(on, nu.dx, nu.dy, gain);
  float step = kContactMeanGain * gain;
  if (contour.known(bin)) {
    const float clipped = Contour::clip(contour.residual(bin, distance));
    step = distance > 0 ? std::min(1.0F, 2 * kContactGain * gain) * clipped / distance : 0;
  }
  track.x = nu.mean_x + step * nu.dx;
  track.y = nu.mean_y + step * nu.dy;
  track.stamp = now;
}

}  // namespace asap::inline v0_1::fast
