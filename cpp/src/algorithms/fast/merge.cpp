#include "algorithms/fast/merge.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "algorithms/fast/gate.hpp"

namespace asap::fast {
namespace {

constexpr std::uint32_t kKnownEvents = 20;  // before, a polarity means nothing

bool is_sibling(const Tracks& tracks, Tracks::Slot of, Tracks::Slot other) noexcept {
  const Life& life = tracks.life(of);
  return life.sibling == other && life.sibling_generation == tracks[other].generation;
}

bool has_changed(const MergeState& state, const Candidate& pair, float tolerance_px,
                 float rotation_px) noexcept {
  const float moved = length(pair.dx - state.dx, pair.dy - state.dy);
  const float stretched = std::abs(pair.distance_px - length(state.dx, state.dy));
  return moved > tolerance_px + rotation_px || stretched > tolerance_px;
}

// Whether a track has a leading and a trailing edge, which fire with opposite polarities.
bool is_whole(const Tracks& tracks, Tracks::Slot slot) noexcept {
  constexpr float kOneSided = 0.6F;
  return tracks[slot].events >= kKnownEvents && std::abs(tracks.contour(slot).polarity) < kOneSided;
}

// Of a tentative track beside a confirmed one.
bool is_fragment(const Track& tentative, const MergeState& state, bool whole) noexcept {
  if (whole) return state.hold_s >= 0.08F;
  if (tentative.events < kKnownEvents && state.hold_s < 0.03F) return false;
  return state.hold_s >= 0.008F && (state.travel_px >= 1 || state.hold_s >= 0.024F);
}

float velocity_difference(const Track& a, const Track& b) noexcept {
  return length(a.vx - b.vx, a.vy - b.vy);
}

float fastest(const Track& a, const Track& b) noexcept {
  return std::max(length(a.vx, a.vy), length(b.vx, b.vy));
}

// Within what the filters know of the velocities.
bool move_alike(const Tracks& tracks, const Candidate& pair) noexcept {
  const Track& a = tracks[pair.keeper];
  const Track& b = tracks[pair.other];
  const float variance = tracks.life(pair.keeper).kalman.pvv + tracks.life(pair.other).kalman.pvv;
  return velocity_difference(a, b) <= 2 * std::sqrt(variance) + 0.2F * fastest(a, b) + 10;
}

// Whether two that had been apart would have parted again, had each gone on as before they met.
bool would_have_parted(const Life& a, const Life& b, float hold_s) noexcept {
  constexpr float kApart_px = 10;
  constexpr float kAgeOfStrangers_s = 0.1F;
  constexpr float kLongest_s = 0.3F;  // who moved alike before leaves no other evidence
  if (std::min(a.confirmed_s, b.confirmed_s) <= kAgeOfStrangers_s) return true;
  const float speed = length(a.usual_vx - b.usual_vx, a.usual_vy - b.usual_vy);
  return hold_s * speed >= kApart_px || hold_s >= kLongest_s;
}

bool overlap_and_move_alike(const Tracks& tracks, const Candidate& pair, const MergeState& state,
                            bool siblings) noexcept {
  const Track& a = tracks[pair.keeper];
  const Track& b = tracks[pair.other];
  const float extent =
      std::max(tracks.life(pair.keeper).extent_px, tracks.life(pair.other).extent_px);
  return pair.distance_px < 0.7F * extent && state.hold_s >= 0.03F && state.travel_px >= 3 &&
         velocity_difference(a, b) < 0.6F * fastest(a, b) + 25 &&
         (siblings ||
          would_have_parted(tracks.life(pair.keeper), tracks.life(pair.other), state.hold_s));
}

// Two that could each be an object: only a long way together makes them one.
bool are_one_whole(const Tracks& tracks, const Candidate& pair, const MergeState& state,
                   bool siblings) noexcept {
  if (overlap_and_move_alike(tracks, pair, state, siblings)) return true;
  if (!siblings && !move_alike(tracks, pair)) return false;
  return state.hold_s >= 0.03F && state.travel_px >= 20;
}

// Two of which one at least shows a single edge.
bool are_one_in_parts(const Tracks& tracks, const Candidate& pair, const MergeState& state,
                      bool siblings) noexcept {
  if (overlap_and_move_alike(tracks, pair, state, siblings)) return true;
  const float younger_s =
      std::min(tracks.life(pair.keeper).confirmed_s, tracks.life(pair.other).confirmed_s);
  if (younger_s < 0.08F) return state.hold_s >= 0.01F && state.travel_px >= 1.5F;
  if (younger_s > 0.4F && !siblings) {
    return state.hold_s >= 0.1F && state.travel_px >= 15 && move_alike(tracks, pair);
  }
  return (state.hold_s >= 0.03F && state.travel_px >= 5) || state.hold_s >= 0.15F;
}

}  // namespace

bool are_one(Tracks& tracks, const Candidate& pair, float dt_s, const MergeRule& rule) noexcept {
  const Track& a = tracks[pair.keeper];
  const Track& b = tracks[pair.other];
  if (!a.has_id() && !b.has_id()) return true;

  MergeState& state = tracks.life(pair.keeper).merge;
  const bool siblings = are_siblings(tracks, pair.keeper, pair.other);
  const bool same = state.partner == pair.other && state.generation == b.generation;
  const float rotation_px = siblings ? rule.rotation_rad * pair.distance_px : 0;
  if (!same || has_changed(state, pair, rule.tolerance_px, rotation_px)) {
    state = {.partner = pair.other, .generation = b.generation, .dx = pair.dx, .dy = pair.dy};
    return false;
  }
  const Track& leader = tracks[survivor_of(tracks, pair.keeper, pair.other)];
  state.hold_s += dt_s;
  state.travel_px += length(leader.vx, leader.vy) * dt_s;

  const bool whole = is_whole(tracks, pair.keeper) && is_whole(tracks, pair.other);
  if (!a.has_id()) return is_fragment(a, state, whole);
  if (!b.has_id()) return is_fragment(b, state, whole);
  return whole ? are_one_whole(tracks, pair, state, siblings)
               : are_one_in_parts(tracks, pair, state, siblings);
}

bool are_siblings(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept {
  return is_sibling(tracks, a, b) || is_sibling(tracks, b, a);
}

void find_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now, const PairRule& rule) noexcept {
  Life& life = tracks.life(slot);
  const Sight here = sight_of(tracks[slot], now, 0, 0);
  float nearest = std::numeric_limits<float>::infinity();
  for (const Tracks::Slot other : tracks.active()) {
    if (other == slot || !tracks[other].has_id()) continue;
    const Sight s = sight_of(tracks[other], now, here.mean_x, here.mean_y);
    const float distance = length(s.dx, s.dy);
    const float reach = merge_distance(life.extent_px + tracks.life(other).extent_px, rule);
    if (distance > reach || distance >= nearest) continue;
    nearest = distance;
    life.sibling = other;
    life.sibling_generation = tracks[other].generation;
  }
}

void forget_far_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now,
                        const PairRule& rule) noexcept {
  Life& life = tracks.life(slot);
  if (life.sibling == MergeState::kNobody) return;
  if (is_sibling(tracks, slot, life.sibling)) {
    constexpr float kMargin_px = 4;
    const Track& other = tracks[life.sibling];
    const Sight there = sight_of(other, now, 0, 0);
    const Sight s = sight_of(tracks[slot], now, there.mean_x, there.mean_y);
    const float extents = life.extent_px + tracks.life(life.sibling).extent_px;
    if (length(s.dx, s.dy) <= merge_distance(extents, rule) + kMargin_px) return;
  }
  life.sibling = MergeState::kNobody;
}

Tracks::Slot survivor_of(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept {
  if (tracks[a].has_id() != tracks[b].has_id()) return tracks[a].has_id() ? a : b;
  if (tracks[a].has_id()) return tracks[a].id < tracks[b].id ? a : b;
  return tracks[a].events >= tracks[b].events ? a : b;
}

void merge(Tracks& tracks, Tracks::Slot survivor, Tracks::Slot other, Stamp now) noexcept {
  Track& track = tracks[survivor];
  Life& life = tracks.life(survivor);
  const Track& gone = tracks[other];
  const Life& gone_life = tracks.life(other);

  const auto mass_of = [](const Track& t, const Life& l) {
    return l.mass + static_cast<float>(t.events - l.events);
  };
  const float gone_mass = mass_of(gone, gone_life);
  const float total = gone_mass + mass_of(track, life);
  const float w = total > 0 ? gone_mass / total : 0.5F;
  const Sight there = sight_of(gone, now, 0, 0);
  const Sight s = sight_of(track, now, there.mean_x, there.mean_y);
  track.sxx = (1 - w) * track.sxx + w * gone.sxx + w * (1 - w) * s.dx * s.dx;
  track.sxy = (1 - w) * track.sxy + w * gone.sxy + w * (1 - w) * s.dx * s.dy;
  track.syy = (1 - w) * track.syy + w * gone.syy + w * (1 - w) * s.dy * s.dy;
  // What is new since the last tick stays new: it is the tick that counts it.
  if (track.events != life.events) life.last_event = track.stamp;
  if (age_us(gone_life.last_event, life.last_event) > 0) life.last_event = gone_life.last_event;
  track.x = s.mean_x + w * s.dx;
  track.y = s.mean_y + w * s.dy;
  track.stamp = now;
  life.kalman.x += w * s.dx;
  life.kalman.y += w * s.dy;
  life.mass += gone_mass;
  life.fast_rate_hz += gone_life.fast_rate_hz;
  life.slow_rate_hz += gone_life.slow_rate_hz;
  tracks.contour(survivor).forget_radius();
}

}  // namespace asap::fast
