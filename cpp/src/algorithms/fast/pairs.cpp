#include "algorithms/fast/pairs.hpp"

#include <algorithm>
#include <cmath>

#include "algorithms/fast/fragment.hpp"
#include "algorithms/fast/gate.hpp"

namespace asap::fast {
namespace {

// Opposite edges of a large object are confirmed apart; the extents of edges are small.
constexpr float kConfirmedMargin_px = 8;

// Parts of one object lie closer, each with an id.
constexpr float kNeighbour_px = 35;

// Standard deviation along a direction, at least a pixel.
float spread_along(const Track& track, float ux, float uy) noexcept {
  return std::sqrt(
      std::max(1.0F, ux * ux * track.sxx + 2 * ux * uy * track.sxy + uy * uy * track.syy));
}

bool touch(const Track& a, const Track& b, float dx, float dy, float distance_px,
           const PairRule& rule) noexcept {
  const float ux = distance_px > 0 ? dx / distance_px : 1;
  const float uy = distance_px > 0 ? dy / distance_px : 0;
  const float spreads = spread_along(a, ux, uy) + spread_along(b, ux, uy);
  return distance_px < rule.contact_reach * spreads + rule.contact_padding_px;
}

void add_partner(Track& track, Life& life, Tracks::Slot partner) noexcept {
  if (track.partners < kMaxPartners) life.partners[track.partners++] = partner;
}

}  // namespace

float merge_distance(float extents_px, const PairRule& rule) noexcept {
  return std::max(0.9F * rule.birth_radius_px,
                  rule.merge_reach * extents_px + rule.merge_padding_px);
}

Pairs::Pairs(std::size_t slots) {
  places_.reserve(slots);
  nearest_.reserve(slots);
  candidates_.reserve(slots);
}

void Pairs::find(Tracks& tracks, Stamp now, const PairRule& rule) noexcept {
  places_.clear();
  nearest_.clear();
  candidates_.clear();
  float largest = 0;
  for (const Tracks::Slot slot : tracks.active()) {
    Track& track = tracks[slot];
    Life& life = tracks.life(slot);
    track.partners = 0;
    life.near_confirmed = false;
    life.may_be_fragment = false;
    const Sight s = sight_of(track, now, 0, 0);
    places_.push_back({s.mean_x, s.mean_y, life.extent_px, slot, track.has_id()});
    nearest_.push_back({Tracks::kNone, Tracks::kNone, 0, 0, 0});
    largest = std::max(largest, life.extent_px);
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place a = places_[i];
    const float reach = merge_distance(a.extent + largest, rule) + kConfirmedMargin_px;
    for (std::size_t j = i + 1; j < places_.size(); ++j) {
      const float dx = places_[j].x - a.x;
      const float dy = places_[j].y - a.y;
      const float distance2 = dx * dx + dy * dy;
      if (distance2 <= reach * reach) meet(tracks, i, j, dx, dy, distance2, rule);
    }
  }
  for (const Candidate& candidate : nearest_) {
    if (candidate.other != Tracks::kNone) candidates_.push_back(candidate);
  }
}

void Pairs::meet(Tracks& tracks, std::size_t i, std::size_t j, float dx, float dy, float distance2,
                 const PairRule& rule) noexcept {
  const Place& a = places_[i];
  const Place& b = places_[j];
  const float distance = std::sqrt(distance2);
  const float margin = a.has_id && b.has_id ? kConfirmedMargin_px : 0;
  if (distance > merge_distance(a.extent + b.extent, rule) + margin) return;

  if (a.has_id && b.has_id && touch(tracks[a.slot], tracks[b.slot], dx, dy, distance, rule)) {
    add_partner(tracks[a.slot], tracks.life(a.slot), b.slot);
    add_partner(tracks[b.slot], tracks.life(b.slot), a.slot);
  }
  const bool second_keeps = a.has_id && !b.has_id;
  const bool close = !(a.has_id && b.has_id) || distance < kNeighbour_px;
  if (b.has_id && close) tracks.life(a.slot).near_confirmed = true;
  if (a.has_id && close) tracks.life(b.slot).near_confirmed = true;
  if (a.has_id != b.has_id) {
    const Tracks::Slot newborn = second_keeps ? b.slot : a.slot;
    const Tracks::Slot grown = second_keeps ? a.slot : b.slot;
    if (may_be_fragment(tracks, newborn, grown, dx, dy)) {
      tracks.life(newborn).may_be_fragment = true;
    }
  }
  Candidate& nearest = nearest_[second_keeps ? j : i];
  if (nearest.other != Tracks::kNone && nearest.distance_px <= distance) return;
  nearest = second_keeps ? Candidate{b.slot, a.slot, -dx, -dy, distance}
                         : Candidate{a.slot, b.slot, dx, dy, distance};
}

}  // namespace asap::fast
