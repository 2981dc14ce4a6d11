// Contact: clusters that touch compete for each event by how well it fits their outlines; the owner
// of the cell has an advantage. Covariance and contour are frozen meanwhile, or each would learn
// the other's edges. Inline, O(partners), no allocation.
// Source: own design.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "algorithms/fast/contour.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/mean_update.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

struct ContactRule {
  float gain;                // [kgain]
  float variance_floor_px2;  // [lk]
  float owner_cost;          // [hyst]
  float mean_gain;           // [cgain]
};

// What it costs a track to take the event: residuals in standard deviations where the outline is
// known, else how far the event is from where an outline usually lies in the gate.
inline float contact_cost(const Contour& contour, const Sight& s, float gate, std::size_t bin,
                          const ContourRule& outline, const ContactRule& rule) noexcept {
  if (!contour.known(bin, outline)) return std::abs(6 * std::sqrt(gate) - 4);
  const float distance = std::sqrt(s.dx * s.dx + s.dy * s.dy);
  return 1.5F * std::abs(contour.residual(bin, distance)) /
         std::sqrt(contour.variance + rule.variance_floor_px2);
}

// The track that takes an event which the owner's gate accepts.
inline Tracks::Slot winner_of(Tracks& tracks, Tracks::Slot owner, Stamp now, float x, float y,
                              const ContourRule& outline, const ContactRule& rule,
                              const DirectionTable& directions) noexcept {
  const auto cost_of = [&](Tracks::Slot slot, float& cost) {
    const Sight s = sight_of(tracks[slot], now, x, y);
    const float gate = gate_value(tracks[slot], s);
    if (!(gate <= 1)) return false;
    cost = contact_cost(tracks.contour(slot), s, gate, directions.bin(s.dx, s.dy), outline, rule);
    return true;
  };
  Tracks::Slot best = owner;
  float least = 0;
  cost_of(owner, least);
  least *= rule.owner_cost;
  for (std::uint8_t i = 0; i < tracks[owner].partners; ++i) {
    const Tracks::Slot partner = tracks.life(owner).partners[i];
    float cost = 0;
    if (!tracks[partner].has_id() || !cost_of(partner, cost) || !(cost < least)) continue;
    least = cost;
    best = partner;
  }
  return best;
}

// How it takes it.
inline void take_in_contact(Track& track, Contour& contour, const Sight& s, Stamp now, float sign,
                            const UpdateRule& update, const ContactRule& rule,
                            const Reciprocals& reciprocals,
                            const DirectionTable& directions) noexcept {
  const std::uint32_t n = ++track.events;
  const float gain = reciprocals[std::min(n, update.mean_events)];
  const std::size_t bin = directions.bin(s.dx, s.dy);
  contour.polarity += gain * (sign - contour.polarity);
  float step = rule.mean_gain * gain;
  if (contour.known(bin, update.contour)) {
    const float distance = std::sqrt(s.dx * s.dx + s.dy * s.dy);
    const float clip = update.contour.clip_px;
    const float clipped = std::clamp(contour.residual(bin, distance), -clip, clip);
    step = distance > 0 ? std::min(1.0F, 2 * rule.gain * gain) * clipped / distance : 0;
  }
  track.x = s.mean_x + step * s.dx;
  track.y = s.mean_y + step * s.dy;
  track.stamp = now;
}

}  // namespace asap::fast
