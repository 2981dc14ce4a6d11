#include "algorithms/fast/lifecycle.hpp"

#include <algorithm>
#include <cmath>

#include "algorithms/fast/decay.hpp"

namespace asap::fast {
namespace {

constexpr float kShortest_s = 1e-6F;
constexpr float kFastRate_s = 0.008F;
constexpr float kSlowRate_s = 0.06F;
constexpr float kMotion_s = 0.2F;
constexpr float kExtent_s = 1;  // two that part slowly must not become the usual
constexpr float kShortestTentative_s = 0.005F;
constexpr float kLongestTentative_s = 0.15F;
constexpr float kWaitNearConfirmed_s = 0.03F;  // a fragment is merged before it has an id

// Events that noise alone stays below.
float noise_bound(float expected, float sigma) noexcept {
  return expected + sigma * std::sqrt(expected);
}

// Of an object that fires at least as much again as the noise. Bounded, so that it can turn.
void weigh(Life& life, float fresh, float dt_s, float noise_hz, const LifeRule& rule) noexcept {
  constexpr float kMost = 30;
  constexpr float kLeastNoise = 0.02F;
  const float object_hz = std::max(rule.birth_rate_hz, noise_hz);
  const float gain = logarithm(1 + object_hz / std::max(noise_hz, kLeastNoise * object_hz));
  life.evidence = std::min(kMost, life.evidence + fresh * gain - object_hz * dt_s);
}

Fate judge_tentative(const Life& life, float noise_hz, const LifeRule& rule) noexcept {
  if (life.evidence < -rule.drop_evidence && life.age_s > kShortestTentative_s) return Fate::kDies;
  if (life.age_s > kLongestTentative_s) return Fate::kDies;
  const float expected = noise_hz * std::min(life.age_s, rule.mass_s);
  if (life.evidence < rule.confirm_evidence ||
      life.mass < rule.confirm_events + noise_bound(expected, 2)) {
    return Fate::kLives;
  }
  if (life.may_be_fragment) return Fate::kLives;
  if (life.near_confirmed && life.age_s <= kWaitNearConfirmed_s) return Fate::kLives;
  return Fate::kConfirmed;
}

// Time since the mass fell below `least`: more than nothing if the tick comes late.
float short_of_mass_s(float mass_before, float least, float dt_s, const LifeRule& rule) noexcept {
  const float step_s = rule.mass_s / 4;
  const float step_decay = decay(0.25F);
  for (; mass_before > least && dt_s > step_s; dt_s -= step_s) mass_before *= step_decay;
  return dt_s;
}

Fate judge_confirmed(Track& track, Life& life, const Tick& tick, float mass_before, float noise_hz,
                     const LifeRule& rule) noexcept {
  const float expected = noise_hz * rule.mass_s;
  const float least = rule.die_events + noise_bound(expected, rule.die_sigma);
  if (track.phase == Phase::kConfirmed) {
    if (life.mass >= least) return Fate::kLives;
    track.phase = Phase::kCoasting;
    life.coasting_s = short_of_mass_s(mass_before, least, tick.dt_s, rule);
  } else {
    life.coasting_s += tick.dt_s;
  }
  if (life.coasting_s > rule.coast_s) return Fate::kDies;
  if (life.mass >= 0.7F * rule.confirm_events + noise_bound(expected, 3)) {
    track.phase = Phase::kConfirmed;
  }
  return Fate::kLives;
}

// Of the events since the last tick: nothing to speak of but after silence.
float decay_since(const Track& track, const Tick& tick, const LifeRule& rule) noexcept {
  const float since_s = 1e-6F * static_cast<float>(age_us(tick.now, track.stamp));
  return since_s > rule.mass_s / 4 ? decay(since_s / rule.mass_s) : 1;
}

void measure_rates(Life& life, float fresh, float dt_s, const Tick& tick, float noise_hz,
                   const LifeRule& rule, bool tentative) noexcept {
  const float rate_hz = fresh / dt_s;
  life.fast_rate_hz +=
      low_pass_weight(tick.fast_decay, dt_s, life.age_s) * (rate_hz - life.fast_rate_hz);
  const bool starved =
      !tentative && life.fast_rate_hz < rule.starve_ratio * life.slow_rate_hz + noise_hz / 2;
  life.starved_s = starved ? life.starved_s + dt_s : 0;
  if (starved) return;
  life.slow_rate_hz +=
      low_pass_weight(tick.slow_decay, dt_s, life.age_s) * (rate_hz - life.slow_rate_hz);
}

}  // namespace

Tick::Tick(Stamp at, float elapsed_s, float noise, const LifeRule& rule) noexcept
    : now(at),
      dt_s(elapsed_s),
      noise_hz(noise),
      mass_decay(decay(elapsed_s / rule.mass_s)),
      fast_decay(decay(elapsed_s / kFastRate_s)),
      slow_decay(decay(elapsed_s / kSlowRate_s)),
      motion_decay(decay(elapsed_s / kMotion_s)),
      extent_decay(decay(elapsed_s / kExtent_s)) {}

void remember_extent(Life& life, float extent2, const Tick& tick) noexcept {
  const float dt_s = std::max(kShortest_s, std::min(tick.dt_s, life.age_s));
  const float weight = low_pass_weight(tick.extent_decay, dt_s, life.age_s);
  life.usual_extent2 += weight * (extent2 - life.usual_extent2);
}

Fate live(Track& track, Life& life, const Tick& tick, const LifeRule& rule,
          const GateRule& gate) noexcept {
  life.age_s += tick.dt_s;
  const float dt_s = std::max(kShortest_s, std::min(tick.dt_s, life.age_s));
  const auto fresh = static_cast<float>(track.events - life.events);
  if (track.events != life.events) life.last_event = track.stamp;
  life.events = track.events;

  const float mass_before = life.mass + fresh;
  life.mass = life.mass * tick.mass_decay + fresh * decay_since(track, tick, rule);
  const bool tentative = track.phase == Phase::kTentative;
  const bool grown = !tentative && life.age_s >= rule.mature_s;
  const float noise_hz = tick.noise_hz * gate_area(track, gate, grown);
  measure_rates(life, fresh, dt_s, tick, noise_hz, rule, tentative);
  if (tentative) {
    weigh(life, fresh, dt_s, noise_hz, rule);
    return judge_tentative(life, noise_hz, rule);
  }
  life.confirmed_s += tick.dt_s;
  return judge_confirmed(track, life, tick, mass_before, noise_hz, rule);
}

}  // namespace asap::fast
