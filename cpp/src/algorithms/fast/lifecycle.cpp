#include "algorithms/fast/lifecycle.hpp"

#include <algorithm>
#include <cmath>

namespace asap::inline v0_1::fast {
namespace {

constexpr float kShortest_s = 1e-6F;
// Time constants of the averages.
constexpr float kFastRate_s = 0.008F;
constexpr float kSlowRate_s = 0.06F;
constexpr float kMotion_s = 0.2F;
constexpr float kExtent_s = 1;  // long, so that two objects that separate slowly are noticed
// Ages of a tentative track: not dropped by its evidence before, not kept after, not confirmed near
// a confirmed track before, so that a fragment is merged before it has an id.
constexpr float kShortestTentative_s = 0.005F;
constexpr float kLongestTentative_s = 0.15F;
constexpr float kWaitNearConfirmed_s = 0.03F;

// Upper bound on the count that noise alone explains.
float noise_bound(float expected, float sigma) noexcept {
  return expected + sigma * std::sqrt(expected);
}

// Updates the log-likelihood ratio of an object in noise, which fires at least as often as the
// noise, against noise alone. It is bounded, so that it falls in time once the events end.
void update_evidence(TrackState& state, float fresh, float dt_s, float noise_hz,
                     const LifecycleRule& rule) noexcept {
  constexpr float kMax = 30;
  constexpr float kMinNoise = 0.02F;
  const float object_hz = std::max(rule.birth_rate_hz, noise_hz);
  const float gain = logarithm(1 + object_hz / std::max(noise_hz, kMinNoise * object_hz));
  state.evidence = std::min(kMax, state.evidence + fresh * gain - object_hz * dt_s);
}

// A small object, such as an insect, has few events.
float confirm_events(const TrackState& state, const LifecycleRule& rule) noexcept {
  constexpr float kSmall_px = 4;
  constexpr float kShare = 4.0F / 7;
  return state.extent_px < kSmall_px ? kShare * rule.confirm_events : rule.confirm_events;
}

Assessment assess_tentative(const TrackState& state, float noise_hz,
                            const LifecycleRule& rule) noexcept {
  if (state.evidence < -kDropEvidence && state.age_s > kShortestTentative_s)
    return Assessment::kDelete;
  if (state.age_s > kLongestTentative_s) return Assessment::kDelete;
  const float expected = noise_hz * std::min(state.age_s, kMass_s);
  if (state.evidence < kConfirmEvidence ||
      state.mass < confirm_events(state, rule) + noise_bound(expected, 2)) {
    return Assessment::kKeep;
  }
  if (state.may_be_fragment) return Assessment::kKeep;
  if (state.near_confirmed && state.age_s <= kWaitNearConfirmed_s) return Assessment::kKeep;
  return Assessment::kConfirm;
}

// Time since the mass fell below `least`, at most dt_s. It matters if the tick comes late.
float time_below_s(float mass_before, float min, float dt_s) noexcept {
  const float step_s = kMass_s / 4;
  const float step_decay = decay(0.25F);
  for (; mass_before > min && dt_s > step_s; dt_s -= step_s) mass_before *= step_decay;
  return dt_s;
}

Assessment assess_confirmed(Track& track, TrackState& state, const Tick& tick, float mass_before,
                            float noise_hz, const LifecycleRule& rule) noexcept {
  const float expected = noise_hz * kMass_s;
  const float min = rule.die_events + noise_bound(expected, kDieSigma);
  if (track.phase == Phase::kConfirmed) {
    if (state.mass >= min) return Assessment::kKeep;
    track.phase = Phase::kCoasting;
    state.coasting_s = time_below_s(mass_before, min, tick.dt_s);
  } else {
    state.coasting_s += tick.dt_s;
  }
  if (state.coasting_s > rule.coast_s) return Assessment::kDelete;
  if (state.mass >= 0.7F * rule.confirm_events + noise_bound(expected, 3)) {
    track.phase = Phase::kConfirmed;
  }
  return Assessment::kKeep;
}

// Decay of the events since the last tick. It matters after a silence only.
float decay_since(const Track& track, const Tick& tick) noexcept {
  const float since_s = age_s(tick.now, track.stamp);
  return since_s > kMass_s / 4 ? decay(since_s / kMass_s) : 1;
}

void measure_rates(TrackState& state, float fresh, float dt_s, const Tick& tick, float noise_hz,
                   bool tentative) noexcept {
  const float rate_hz = fresh / dt_s;
  state.fast_rate_hz +=
      low_pass_weight(tick.fast_decay, dt_s, state.age_s) * (rate_hz - state.fast_rate_hz);
  const bool starved =
      !tentative && state.fast_rate_hz < kStarveRatio * state.slow_rate_hz + noise_hz / 2;
  state.starved_s = starved ? state.starved_s + dt_s : 0;
  if (starved) return;
  state.slow_rate_hz +=
      low_pass_weight(tick.slow_decay, dt_s, state.age_s) * (rate_hz - state.slow_rate_hz);
}

}  // namespace

Tick::Tick(Stamp at, float elapsed_s, float noise) noexcept
    : now(at),
      dt_s(elapsed_s),
      noise_hz(noise),
      mass_decay(decay(elapsed_s / kMass_s)),
      fast_decay(decay(elapsed_s / kFastRate_s)),
      slow_decay(decay(elapsed_s / kSlowRate_s)),
      motion_decay(decay(elapsed_s / kMotion_s)),
      extent_decay(decay(elapsed_s / kExtent_s)) {}

void record_motion(const Track& track, TrackState& state, const Tick& tick) noexcept {
  const Point mean = predicted_mean(track, tick.now);
  state.last_seen_x = mean.x;
  state.last_seen_y = mean.y;
  const float weight = 1 - tick.motion_decay;
  state.average_vx += weight * (track.vx - state.average_vx);
  state.average_vy += weight * (track.vy - state.average_vy);
}

void return_to_last_seen(Track& track, TrackState& state) noexcept {
  track.x = state.kalman.x = state.last_seen_x;
  track.y = state.kalman.y = state.last_seen_y;
  track.vx = 0;
  track.vy = 0;
}

void record_extent(TrackState& state, float extent2, const Tick& tick) noexcept {
  const float dt_s = std::max(kShortest_s, std::min(tick.dt_s, state.age_s));
  const float weight = low_pass_weight(tick.extent_decay, dt_s, state.age_s);
  state.average_extent2 += weight * (extent2 - state.average_extent2);
}

Assessment assess(Track& track, TrackState& state, const Tick& tick,
                  const LifecycleRule& rule) noexcept {
  state.age_s += tick.dt_s;
  state.fragment_s += tick.dt_s;
  const float dt_s = std::max(kShortest_s, std::min(tick.dt_s, state.age_s));
  const auto fresh = static_cast<float>(track.events - state.events);
  if (track.events != state.events) state.last_event = track.stamp;
  state.events = track.events;

  const float mass_before = state.mass + fresh;
  state.mass = state.mass * tick.mass_decay + fresh * decay_since(track, tick);
  const bool tentative = track.phase == Phase::kTentative;
  const bool mature = !tentative && state.age_s >= kMature_s;
  const float noise_hz =
      tick.noise_hz * (mature ? mature_gate_area(track) : young_gate_area(state.young_radius_px));
  measure_rates(state, fresh, dt_s, tick, noise_hz, tentative);
  if (tentative) {
    update_evidence(state, fresh, dt_s, noise_hz, rule);
    return assess_tentative(state, noise_hz, rule);
  }
  state.confirmed_s += tick.dt_s;
  return assess_confirmed(track, state, tick, mass_before, noise_hz, rule);
}

void update_gate(Track& track, TrackState& state, const GateRule& gate, float widest_px) noexcept {
  state.young_radius_px = young_radius(state, gate, widest_px);
  if (!track.has_id()) return shape_birth_gate(track, state.young_radius_px);
  state.gate_scale = ellipse_scale(state);
  shape_gate(track, gate, state.gate_scale, state.young_radius_px,
             state.extent_px * state.extent_px, state.age_s >= kMature_s,
             is_starved(state) ? state.kalman.pxx : 0);
}

bool has_left(const Track& track, Stamp now, const Frame& frame) noexcept {
  const Point mean = predicted_mean(track, now);
  const auto right = static_cast<float>(frame.width + 2);
  const auto bottom = static_cast<float>(frame.height + 2);
  return !(mean.x >= -3 && mean.x <= right && mean.y >= -3 && mean.y <= bottom);
}

}  // namespace asap::inline v0_1::fast
