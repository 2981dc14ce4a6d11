// How a track takes an event that nobody contests: exponential mean and covariance with a memory in
// events. Once the outline is known, the displacement is blended with twice the radial residual,
// because edges fire unevenly and the plain mean wobbles with them; where noise is common, events
// far from the outline do not count. Inline, O(1), no allocation.
// Source: own design.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "algorithms/fast/contour.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

// 1/n for the memories of the means.
class Reciprocals {
 public:
  explicit Reciprocals(std::uint32_t most) : values_(most + 1, 1.0F) {
    for (std::uint32_t n = 1; n <= most; ++n) values_[n] = 1 / static_cast<float>(n);
  }
  float operator[](std::uint32_t n) const noexcept { return values_[n]; }

 private:
  std::vector<float> values_;
};

struct UpdateRule {
  std::uint32_t mean_events = 60;         // [n_eff]
  std::uint32_t covariance_events = 300;  // [n_S]
  std::uint32_t contour_mask = 3;  // the contour learns the events whose number has none of these
  float far_trust = 1;             // of events far from the outline
  ContourRule contour;
};

// Events far from an outline are the object's, whose outline is not exact or whose motion changes,
// unless noise is common: hz per pixel, of what reaches the tracks.
inline float far_trust(float noise_hz) noexcept {
  constexpr float kRare_hz = 0.1F;
  constexpr float kCommon_hz = 0.5F;
  return std::clamp((kCommon_hz - noise_hz) / (kCommon_hz - kRare_hz), 0.0F, 1.0F);
}

struct WeightRule {
  float least;  // [wmin]
  float scale;  // [wk]
};

// Of the plain mean, by inverse variances: textured objects, whose events fill their outline, fall
// back to it.
inline float mean_weight(const Track& track, const Contour& contour,
                         const WeightRule& rule) noexcept {
  const float scatter = 2 * rule.scale * contour.variance;
  const float spread = 0.5F * (track.sxx + track.syy) + 0.5F;
  return std::clamp(scatter / (scatter + spread), rule.least, 1.0F);
}

// How much an event counts at this distance from the outline: fully up to 3 px, from 6 px on `far`.
// Textured objects, told by the weight of their plain mean, have events of their own there.
inline float trust(float residual, float mean_weight, float far) noexcept {
  constexpr float kNone_px = 6;
  constexpr float kFade_px = 3;
  const float near = (kNone_px - std::abs(residual)) * (1 / kFade_px);
  const float textured = 5 * mean_weight - 1.5F;
  return std::clamp(std::max(near, textured), far, 1.0F);
}

inline void take(Track& track, Contour& contour, const Sight& s, Stamp now, float sign,
                 const UpdateRule& rule, const Reciprocals& reciprocals,
                 const DirectionTable& directions) noexcept {
  const std::uint32_t n = ++track.events;
  const float gain = reciprocals[std::min(n, rule.mean_events)];
  const float spread_gain = reciprocals[std::min(n, rule.covariance_events)];
  const float distance = std::sqrt(s.dx * s.dx + s.dy * s.dy);
  const std::size_t bin = directions.bin(s.dx, s.dy);
  contour.polarity += gain * (sign - contour.polarity);

  const float residual = contour.residual(bin, distance);
  if ((n & rule.contour_mask) == 0) contour.learn(bin, distance, rule.contour);
  float blend = 1;
  if (n >= rule.mean_events && contour.known(bin, rule.contour) && distance > 0) {
    const float clip = rule.contour.clip_px;
    const float clipped = std::clamp(residual, -clip, clip);
    blend = track.mean_weight + (1 - track.mean_weight) * 2 * clipped / distance;
    blend *= trust(residual, track.mean_weight, rule.far_trust);
  }
  track.x = s.mean_x + gain * blend * s.dx;
  track.y = s.mean_y + gain * blend * s.dy;
  track.stamp = now;
  track.sxx += spread_gain * ((1 - gain) * s.dx * s.dx - track.sxx);
  track.sxy += spread_gain * ((1 - gain) * s.dx * s.dy - track.sxy);
  track.syy += spread_gain * ((1 - gain) * s.dy * s.dy - track.syy);
}

}  // namespace asap::fast
