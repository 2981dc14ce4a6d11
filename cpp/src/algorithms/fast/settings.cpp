#include "algorithms/fast/settings.hpp"

#include <algorithm>
#include <cmath>

namespace asap::fast {
namespace {

float single(double value) noexcept { return static_cast<float>(value); }
float seconds(double ms) noexcept { return static_cast<float>(1e-3 * ms); }
std::int32_t microseconds(double ms) noexcept {
  return static_cast<std::int32_t>(std::lround(1e3 * ms));
}

constexpr double kLongestWindow_ms = 50;
constexpr double kLeastGamma = 0.01;
// With a smaller gamma too many events of objects are without support to reject those. After a
// noise filter upstream little noise is left, so rejection ends earlier.
constexpr double kLeastGammaUnfiltered = 0.15;
constexpr double kLeastGammaFiltered = 0.75;

// Least factors on the thresholds of masses. The masses of weak objects lie little above them and
// fall with gamma, but fewer events than these may be one edge.
constexpr double kFewestConfirm = 0.36;
constexpr double kFewestSeed = 2.0 / 3;

// Gates of 27 to 36 px are good where this bounds the noise in them: 19 px at 5 Hz/px.
constexpr double kNoiseEvents = 30;
// Half or twice of it changes little; recordings without noise need it, for nothing else bounds
// the gate of a sparse object there.
constexpr double kLeastDensity_hz = 1;

float thinned(double events, double gamma, double fewest) noexcept {
  return single(events * std::clamp(4 * gamma, fewest, 1.0));
}

std::uint32_t contour_mask(double gamma) noexcept {
  if (gamma >= 0.75) return 3;
  return gamma >= 0.3 ? 1 : 0;
}

}  // namespace

Settings::Settings(const ClusterTrackerConfig& c) noexcept
    : tick_us(microseconds(c.tick_ms)),
      warmup_us(microseconds(c.warmup_ms)),
      link_us(microseconds(c.link_ms)),
      seed_s(seconds(c.seed_ms)),
      cell_px(single(c.cell_px)),
      uses_support(c.support != ClusterSupport::kOff),
      update{.covariance_events = static_cast<std::uint32_t>(c.covariance_events),
             .contour = {.clip_px = single(c.contour_clip_px),
                         .memory = static_cast<std::uint8_t>(c.contour_events),
                         .min_known = static_cast<std::uint8_t>(c.contour_min_events)},
             .contact_gain = single(c.contact_gain),
             .contact_mean_gain = single(c.contact_mean_gain)},
      weight{.least = single(c.contour_min_weight), .scale = single(c.contour_weight_scale)},
      contact{.variance_floor_px2 = single(c.contact_variance_px2),
              .owner_cost = single(c.contact_owner_cost)},
      gate{.birth_radius_px = single(c.birth_radius_px),
           .min_radius_px = single(c.min_radius_px),
           .max_radius_px = single(c.max_radius_px),
           .scale = single(c.gate_scale),
           .padding_px = single(c.gate_padding_px),
           .circle_scale = single(c.circle_scale),
           .circle_padding_px = single(c.circle_padding_px)},
      kalman{.acceleration = single(c.acceleration_px2_s3),
             .per_speed3 = single(c.acceleration_per_speed_px),
             .most = single(c.max_acceleration_px2_s3),
             .contact = single(c.contact_acceleration_px2_s3),
             .measurement_scale = single(c.measurement_scale),
             .min_measurement_px2 = single(c.min_measurement_px2)},
      lifecycle{.mass_s = seconds(c.mass_ms),
                .die_sigma = single(c.die_sigma),
                .confirm_evidence = single(c.confirm_evidence),
                .drop_evidence = single(c.drop_evidence),
                .starve_ratio = single(c.starve_ratio),
                .velocity_decay_s = seconds(c.velocity_decay_ms),
                .hide_s = seconds(c.hide_ms),
                .coast_s = seconds(c.coast_ms),
                .mature_s = seconds(c.mature_ms)},
      pairs{.birth_radius_px = single(c.birth_radius_px),
            .merge_reach = single(c.merge_reach),
            .merge_padding_px = single(c.merge_padding_px),
            .contact_reach = single(c.contact_reach),
            .contact_padding_px = single(c.contact_padding_px)},
      merge{.tolerance_px = single(c.merge_tolerance_px),
            .rotation_rad = single(c.merge_rotation_rad)} {
  set_keep(c, 1, false);
}

float Settings::birth_threshold(float noise_hz) const noexcept {
  const float around_px = 3 * cell_px;
  const float expected = noise_hz * around_px * around_px * seed_s;
  return std::max(seed_events, expected + 4 * std::sqrt(expected) + 2);
}

void Settings::set_keep(const ClusterTrackerConfig& c, double gamma,
                        bool filtered_upstream) noexcept {
  gamma = std::max(gamma, kLeastGamma);
  const double events = c.mean_events;
  const double kept = std::clamp(2 * events * gamma, events / 3, events);
  update.mean_events = static_cast<std::uint32_t>(std::max(1L, std::lround(kept)));
  kalman.mean_events = update.mean_events;
  update.contour_mask = contour_mask(gamma);
  const double longest = std::max(kLongestWindow_ms, c.support_window_ms);
  const double window = std::min(longest, c.support_window_ms / gamma);
  support_window_us = microseconds(window);
  seed_events = thinned(c.seed_events, gamma, kFewestSeed);
  lifecycle.confirm_events = thinned(c.confirm_events, gamma, kFewestConfirm);
  lifecycle.die_events = thinned(c.die_events, gamma, kFewestConfirm);
  lifecycle.birth_rate_hz = single(c.birth_rate_hz * gamma);
  gate.noise_events = single(kNoiseEvents * gamma);
  gate.least_density_hz = single(kLeastDensity_hz * gamma);
  rejects_unsupported = c.support == ClusterSupport::kReject &&
                        gamma >= (filtered_upstream ? kLeastGammaFiltered : kLeastGammaUnfiltered);
}

}  // namespace asap::fast
