#include "algorithms/fast/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "algorithms/fast/constants.hpp"

namespace asap::inline v0_1::fast {

namespace {

float single(double value) noexcept { return static_cast<float>(value); }
using Milliseconds = std::chrono::duration<double, std::milli>;

float seconds(Milliseconds time) noexcept { return static_cast<float>(1e-3 * time.count()); }
std::int32_t microseconds(Milliseconds time) noexcept {
  return static_cast<std::int32_t>(std::lround(1e3 * time.count()));
}

constexpr Milliseconds kLongestWindow{150};
constexpr Milliseconds kSeed = std::chrono::microseconds(kSeed_us);
constexpr double kMinGamma = 0.01;
// At a smaller gamma too many events of objects lack support to be rejected: they go to tracks and
// begin none, or noise would come back that was left out at a larger gamma. After a noise filter
// upstream little noise is left, so rejection ends earlier.
constexpr double kMinGammaUnfiltered = 0.08;
constexpr double kMinGammaFiltered = 0.75;

// Least factors on the thresholds of masses. The masses of weak objects lie little above them and
// fall with gamma, but fewer events than these may be one edge.
constexpr double kMinConfirm = 0.25;
constexpr double kMinSeed = 0.5;

// Gates of 27 to 36 px are good where this bounds the noise in them: 19 px at 5 Hz/px.
constexpr double kNoiseEvents = 30;
// Half or twice of it changes little; recordings without noise need it, for nothing else bounds
// the gate of a sparse object there.
constexpr double kMinDensity_hz = 1;
// A sparse thing has gaps of its own, which must not cut it. 15 to 40; at 10 the cuts come back.
// With gamma weak objects that became one would stay one, so it falls with the square.
constexpr double kDense_per_px = 15;

float thinned(double events, double gamma, double fewest) noexcept {
  return single(events * std::clamp(4 * gamma, fewest, 1.0));
}

std::uint32_t contour_mask(double gamma) noexcept {
  if (gamma >= 0.75) return 3;
  return gamma >= 0.3 ? 1 : 0;
}

}  // namespace

Settings::Settings(const ClusterTrackerConfig& c) noexcept
    : uses_support(c.support != ClusterSupport::kOff),
      gate{.birth_radius_px = single(c.birth_radius_px), .max_radius_px = single(c.max_radius_px)},
      lifecycle{.coast_s = seconds(c.coast)} {
  set_gamma(c, 1, false);
}

float Settings::birth_threshold(float noise_hz) const noexcept {
  constexpr float kAround_px = 3 * kCell_px;
  const float expected = noise_hz * kAround_px * kAround_px * kSeed_s;
  return std::max(seed_events, expected + 4 * std::sqrt(expected) + 2);
}

void Settings::set_gamma(const ClusterTrackerConfig& c, double gamma,
                         bool filtered_upstream) noexcept {
  gamma = std::max(gamma, kMinGamma);
  constexpr double kEvents = kMeanEvents;
  const double kept = std::clamp(2 * kEvents * gamma, kEvents / 3, kEvents);
  update.mean_events = static_cast<std::uint32_t>(std::max(1L, std::lround(kept)));
  update.contour_mask = contour_mask(gamma);
  const Milliseconds window = c.support_window;
  const Milliseconds longest = std::max(kLongestWindow, window);
  support_window_us = microseconds(std::min(longest, window / gamma));
  // Longer is of no use for all events: the counts of unassociated ones decay with kSeed_us.
  longest_window_us = microseconds(std::max(kSeed, std::min(longest, kSeed / gamma)));
  seed_events = thinned(kSeedEvents, gamma, kMinSeed);
  lifecycle.confirm_events = thinned(c.confirm_events, gamma, kMinConfirm);
  lifecycle.die_events = thinned(kDieEvents, gamma, kMinConfirm);
  lifecycle.birth_rate_hz = single(kBirthRate_hz * gamma);
  gate.noise_events = single(kNoiseEvents * gamma);
  gate.min_density_hz = single(kMinDensity_hz * gamma);
  dense_per_px = single(kDense_per_px * gamma * gamma);
  rejects_unsupported = c.support == ClusterSupport::kReject &&
                        gamma >= (filtered_upstream ? kMinGammaFiltered : kMinGammaUnfiltered);
  begins_unsupported = c.support != ClusterSupport::kReject || filtered_upstream;
}

}  // namespace asap::inline v0_1::fast
