// The life of a track, at the tick: a tentative one is confirmed when its events are more than
// noise explains, for long enough; a confirmed one whose object stops or hides is starved, then
// unlisted, then coasts with id and gate, and is deleted last. One thread. O(1) per track, no
// allocation.
// Source: own design; the evidence is a sequential likelihood-ratio test (Wald 1945).
#pragma once

#include <limits>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

struct LifeRule {
  float mass_s;              // [tau_mass]
  float confirm_events = 0;  // [m_conf], fewer with gamma
  float die_events = 0;      // [m_die], likewise
  float die_sigma;           // [die_s]
  float birth_rate_hz = 0;   // [rho0], times gamma
  float confirm_evidence;    // [llr_conf]
  float drop_evidence;       // [-llr_die]
  float starve_ratio;        // [starve]
  float velocity_decay_s;    // [vdec]
  float hide_s;              // [hide]
  float coast_s;             // [coast]
  float mature_s;            // [mature]
};

// What one tick has in common for all tracks.
struct Tick {
  Tick(Stamp now, float dt_s, float noise_hz, const LifeRule& rule) noexcept;

  Stamp now;
  float dt_s;
  float noise_hz;  // per pixel, of events that reach the tracks
  float mass_decay;
  float fast_decay;
  float slow_decay;
  float motion_decay;
  float extent_decay;
};

enum class Fate { kLives, kConfirmed, kDies };

// Counts what is new and decides. kConfirmed: the caller gives an id.
Fate live(Track& track, Life& life, const Tick& tick, const LifeRule& rule,
          const GateRule& gate) noexcept;

// The usual extent of a track that sees its whole object, and no other.
void remember_extent(Life& life, float extent2, const Tick& tick) noexcept;

// Whether the track has gone without events for so long that it must have stopped.
inline constexpr float kStarved_s = 0.01F;
inline bool is_starved(const Life& life) noexcept { return life.starved_s > kStarved_s; }

// It will at the next tick, and not be listed before.
inline void let_die(Track& track, Life& life) noexcept {
  track.phase = Phase::kCoasting;
  life.coasting_s = std::numeric_limits<float>::infinity();
}

inline bool is_listed(const Track& track, const Life& life, const LifeRule& rule) noexcept {
  return track.phase == Phase::kConfirmed && life.starved_s < rule.hide_s;
}

}  // namespace asap::fast
