#include "algorithms/fast/pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {
namespace {

// Opposite edges of a large object are confirmed apart, and the extents of edges are small.
constexpr float kConfirmedMargin_px = 8;
// Confirmed parts of one object lie closer than this.
constexpr float kNeighbour_px = 35;

constexpr float kOutline_s = 0.05F;         // age from which the outline of a track is known
constexpr std::uint32_t kKnownEvents = 20;  // the mean polarity of fewer is random
constexpr float kOneSided = 0.6F;           // mean polarity from which one edge is missing

bool outlines_meet(const Track& a, const Track& b, float dx, float dy, float distance_px) noexcept {
  const float ux = distance_px > 0 ? dx / distance_px : 1;
  const float uy = distance_px > 0 ? dy / distance_px : 0;
  const float spreads = spread_along(a, ux, uy) + spread_along(b, ux, uy);
  return distance_px < kContactReach * spreads + kContactPadding_px;
}

void add_partner(Track& track, TrackState& state, Tracks::Slot partner) noexcept {
  if (track.partners < kMaxPartners) state.partners[track.partners++] = partner;
}

// px, within which the tips of an object lie that a large track and a tentative one may share.
float tip_distance(float extents_px) noexcept {
  constexpr float kTips = 2.5F;  // standard deviations; 2.45 for an L
  return kTips * extents_px + kMergePadding_px;
}

bool may_miss_parts(const TrackState& confirmed) noexcept {
  return confirmed.extent_px >= kLarge_px && confirmed.age_s > kOutline_s;
}

// px within which two tracks may be one object.
float merge_distance(float extents_px) noexcept {
  return kMergeReach * extents_px + kMergePadding_px;
}

// The gate of a large object misses some of its parts, such as the tips of a star or the ends of a
// bar. They begin as tracks of their own, and once confirmed would take the object's events in
// contact. So a tentative track that lies in the widened gate of a mature one and is small beside
// it waits until it has merged or left.
bool may_be_fragment(const Tracks& tracks, Tracks::Slot tentative, Tracks::Slot confirmed, float dx,
                     float dy) noexcept {
  constexpr float kMaxMass = 0.2F;
  constexpr float kReach = 1.25F;  // factor on the gate
  const TrackState& state = tracks.state(confirmed);
  return state.age_s > kOutline_s && tracks.state(tentative).mass < kMaxMass * state.mass &&
         gate_value(tracks[confirmed], {.mean_x = 0, .mean_y = 0, .dx = dx, .dy = dy}) <=
             kReach * kReach;
}

// ---- siblings ----

bool is_sibling(const Tracks& tracks, Tracks::Slot of, Tracks::Slot other) noexcept {
  const TrackState& state = tracks.state(of);
  return state.sibling == other && state.sibling_generation == tracks[other].generation;
}

// Whether one was confirmed within reach of the other and has not left it since. It is then a part
// of the same object, and not an object that came along.
bool are_siblings(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept {
  return is_sibling(tracks, a, b) || is_sibling(tracks, b, a);
}

// ---- candidates ----

constexpr Candidate kNoCandidate{Tracks::kNone, Tracks::kNone, 0, 0,
                                 std::numeric_limits<float>::infinity()};

// Inserts by distance. The farthest one falls out.
void insert(std::span<Candidate> nearest, Candidate candidate) noexcept {
  for (Candidate& one : nearest) {
    if (candidate.distance_px < one.distance_px) std::swap(one, candidate);
  }
}

// ---- evidence that a pair is one object ----

// The MergeState of a pair, the first of its keeper now. A new pair takes that of the pair which
// has not been a candidate for longest.
MergeState& merge_state(TrackState& keeper, Tracks::Slot other, std::uint16_t generation) noexcept {
  const auto last = keeper.merges.end() - 1;
  const auto own = std::find_if(keeper.merges.begin(), last, [&](const MergeState& state) {
    return state.other == other && state.generation == generation;
  });
  std::rotate(keeper.merges.begin(), own, own + 1);
  return keeper.merges.front();
}

// Time and way for which a pair must keep its relative position.
struct Required {
  float hold_s;
  float travel_px;
};

bool meets(const MergeState& kept, const Required& required) noexcept {
  return kept.hold_s >= required.hold_s && kept.travel_px >= required.travel_px;
}

float larger_extent(const TrackState& a, const TrackState& b) noexcept {
  return std::max(a.extent_px, b.extent_px);
}

// px by which a relative position may change and still count as kept. The means of two large parts
// that lie close together wander, because they share events.
float tolerance(const Tracks& tracks, const Candidate& pair) noexcept {
  constexpr float kExtents = 1.3F;
  constexpr float kPerExtent = 0.35F;
  const TrackState& a = tracks.state(pair.keeper);
  const TrackState& b = tracks.state(pair.other);
  if (pair.distance_px > kExtents * larger_extent(a, b)) return kMergeTolerance_px;
  return std::max(kMergeTolerance_px, kPerExtent * (a.extent_px + b.extent_px));
}

bool has_changed(const MergeState& kept, const Candidate& pair, float tolerance_px,
                 float rotation_px) noexcept {
  const float moved = length(pair.dx - kept.dx, pair.dy - kept.dy);
  const float stretched = std::abs(pair.distance_px - length(kept.dx, kept.dy));
  return moved > tolerance_px + rotation_px || stretched > tolerance_px;
}

// Whether a track is as thin as an arc of a ring, or as a piece of a bar. Its two edges lie close
// together, so both polarities do not say that it is an object.
bool is_thin(const Track& track) noexcept {
  constexpr float kElongation = 5;  // ratio of variances; an outline of 2 to 1 has 4 to 5
  const float largest = largest_variance(track);
  return largest > kElongation * (track.sxx + track.syy - largest);
}

// A tentative track beside a confirmed one. `whole`: both have both edges.
bool is_fragment(const Track& tentative, const MergeState& kept, bool whole) noexcept {
  constexpr float kWhole_s = 0.08F;
  constexpr float kFewEvents_s = 0.03F;
  constexpr Required kMoving{0.008F, 1};
  constexpr float kAtRest_s = 0.024F;
  if (whole) return kept.hold_s >= kWhole_s;
  if (tentative.events < kKnownEvents && kept.hold_s < kFewEvents_s) return false;
  return meets(kept, kMoving) || kept.hold_s >= kAtRest_s;
}

// Two confirmed tracks with both edges that are not thin, each of which may be an object: only a
// long way together is evidence.
bool whole_tracks_are_one(const Tracks& tracks, const Candidate& pair, const MergeState& kept,
                          bool siblings) noexcept {
  constexpr float kLargeSibling_px = 10.5F;
  constexpr Required kOfALarge{0.03F, 5};
  constexpr Required kRequired{0.03F, 20};
  if (!siblings) return meets(kept, kRequired);
  const float larger = larger_extent(tracks.state(pair.keeper), tracks.state(pair.other));
  return meets(kept, larger > kLargeSibling_px ? kOfALarge : kRequired);
}

// Two confirmed tracks, at least one of which is thin or shows a single edge.
bool partial_tracks_are_one(const Tracks& tracks, const Candidate& pair, const MergeState& kept,
                            bool siblings) noexcept {
  constexpr float kYoung_s = 0.08F;
  constexpr Required kYoung{0.01F, 1.5F};
  constexpr float kOld_s = 0.4F;
  constexpr Required kOld{0.1F, 15};
  constexpr Required kMoving{0.03F, 5};
  const float younger_s =
      std::min(tracks.state(pair.keeper).confirmed_s, tracks.state(pair.other).confirmed_s);
  if (younger_s < kYoung_s) return meets(kept, kYoung);
  if (younger_s > kOld_s && !siblings) return meets(kept, kOld);
  return meets(kept, kMoving);
}

}  // namespace

// ---- pairs ----

Pairs::Pairs(std::size_t slots) {
  places_.reserve(slots);
  nearest_.reserve(slots);
  candidates_.reserve(kMaxCandidates * slots);
}

void Pairs::find(Tracks& tracks, Stamp now) noexcept {
  places_.clear();
  nearest_.clear();
  candidates_.clear();
  float largest = 0;
  for (const Tracks::Slot slot : tracks.active()) {
    Track& track = tracks[slot];
    TrackState& state = tracks.state(slot);
    track.partners = 0;
    state.near_confirmed = false;
    state.may_be_fragment = false;
    const Point mean = predicted_mean(track, now);
    places_.push_back({mean.x, mean.y, state.extent_px, slot, track.has_id()});
    nearest_.emplace_back().fill(kNoCandidate);
    largest = std::max(largest, state.extent_px);
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place a = places_[i];
    const float extents = a.extent + largest;
    const float reach =
        std::max(merge_distance(extents) + kConfirmedMargin_px, tip_distance(extents));
    for (std::size_t j = i + 1; j < places_.size(); ++j) {
      const float dx = places_[j].x - a.x;
      const float dy = places_[j].y - a.y;
      if (dx * dx + dy * dy > reach * reach) continue;
      const bool second_keeps = a.has_id && !places_[j].has_id;
      compare(tracks, second_keeps ? j : i, second_keeps ? i : j);
    }
  }
  for (const auto& nearest : nearest_) {
    for (const Candidate& candidate : nearest) {
      if (candidate.other != Tracks::kNone) candidates_.push_back(candidate);
    }
  }
}

void Pairs::compare(Tracks& tracks, std::size_t keeper, std::size_t other) noexcept {
  const Place& a = places_[keeper];
  const Place& b = places_[other];
  const float dx = b.x - a.x;
  const float dy = b.y - a.y;
  const float distance = length(dx, dy);
  const float extents = a.extent + b.extent;
  const bool confirmed = a.has_id && b.has_id;
  const bool mixed = !a.has_id && b.has_id;
  float reach = merge_distance(extents);
  if (confirmed) reach += kConfirmedMargin_px;
  if (mixed && may_miss_parts(tracks.state(b.slot))) reach = std::max(reach, tip_distance(extents));
  if (distance > reach) return;

  if (confirmed && outlines_meet(tracks[a.slot], tracks[b.slot], dx, dy, distance)) {
    add_partner(tracks[a.slot], tracks.state(a.slot), b.slot);
    add_partner(tracks[b.slot], tracks.state(b.slot), a.slot);
  }
  if (confirmed && distance < kNeighbour_px) {
    tracks.state(a.slot).near_confirmed = true;
    tracks.state(b.slot).near_confirmed = true;
  }
  if (mixed) tracks.state(a.slot).near_confirmed = true;
  if (mixed && may_be_fragment(tracks, a.slot, b.slot, dx, dy)) {
    tracks.state(a.slot).may_be_fragment = true;
    note_fragment(tracks[b.slot], tracks.state(b.slot), dx, dy);
  }
  // Smaller objects merge wrongly in crowds if they keep more candidates than the nearest.
  const bool keeps_several = a.has_id && std::max(a.extent, b.extent) > kLarge_px;
  insert(std::span(nearest_[keeper]).first(keeps_several ? kMaxCandidates : 1),
         Candidate{a.slot, b.slot, dx, dy, distance});
}

// ---- merging ----

bool has_both_edges(const Tracks& tracks, Tracks::Slot slot) noexcept {
  return tracks[slot].events >= kKnownEvents && std::abs(tracks.contour(slot).polarity) < kOneSided;
}

bool has_edges_apart(const Tracks& tracks, Tracks::Slot slot) noexcept {
  constexpr float kExplained = 0.5F;  // share of the polarity's variance that the place explains
  const Track& track = tracks[slot];
  const Contour& contour = tracks.contour(slot);
  const float x = contour.dipole_x;
  const float y = contour.dipole_y;
  const float determinant = track.sxx * track.syy - track.sxy * track.sxy;
  return track.events >= kKnownEvents &&
         track.syy * x * x - 2 * track.sxy * x * y + track.sxx * y * y >
             kExplained * (1 - contour.polarity * contour.polarity) * determinant;
}

bool have_opposite_edges(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept {
  const auto edge_of = [&](Tracks::Slot slot) {
    const float polarity = tracks.contour(slot).polarity;
    if (tracks[slot].events < kKnownEvents || std::abs(polarity) < kOneSided) return 0;
    return polarity > 0 ? 1 : -1;
  };
  return edge_of(a) * edge_of(b) < 0;
}

bool are_one(Tracks& tracks, const Candidate& pair, float dt_s) noexcept {
  const Track& a = tracks[pair.keeper];
  const Track& b = tracks[pair.other];
  if (!a.has_id() && !b.has_id()) return true;

  MergeState& kept = merge_state(tracks.state(pair.keeper), pair.other, b.generation);
  const bool siblings = are_siblings(tracks, pair.keeper, pair.other);
  const bool same = kept.other == pair.other && kept.generation == b.generation;
  const float rotation_px = siblings ? kMergeRotation_rad * pair.distance_px : 0;
  if (!same || has_changed(kept, pair, tolerance(tracks, pair), rotation_px)) {
    kept = {.other = pair.other, .generation = b.generation, .dx = pair.dx, .dy = pair.dy};
    return false;
  }
  const Track& leader = tracks[survivor_of(tracks, pair.keeper, pair.other)];
  kept.hold_s += dt_s;
  kept.travel_px += length(leader.vx, leader.vy) * dt_s;

  const bool whole = has_both_edges(tracks, pair.keeper) && has_both_edges(tracks, pair.other);
  if (!a.has_id()) return is_fragment(a, kept, whole);
  if (!b.has_id()) return is_fragment(b, kept, whole);
  return whole && !is_thin(a) && !is_thin(b) ? whole_tracks_are_one(tracks, pair, kept, siblings)
                                             : partial_tracks_are_one(tracks, pair, kept, siblings);
}

Tracks::Slot survivor_of(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept {
  if (tracks[a].has_id() != tracks[b].has_id()) return tracks[a].has_id() ? a : b;
  if (tracks[a].has_id()) return tracks[a].id < tracks[b].id ? a : b;
  return tracks[a].events >= tracks[b].events ? a : b;
}

void merge(Tracks& tracks, Tracks::Slot survivor, Tracks::Slot other, Stamp now) noexcept {
  Track& track = tracks[survivor];
  TrackState& state = tracks.state(survivor);
  const Track& gone = tracks[other];
  const TrackState& gone_state = tracks.state(other);

  // The events that no tick has counted yet belong to the mass.
  const auto mass_of = [](const Track& t, const TrackState& s) {
    return s.mass + static_cast<float>(t.events - s.events);
  };
  const float gone_mass = mass_of(gone, gone_state);
  const float total = gone_mass + mass_of(track, state);
  const float w = total > 0 ? gone_mass / total : 0.5F;
  const Point there = predicted_mean(gone, now);
  const Point here = predicted_mean(track, now);
  const float dx = there.x - here.x;
  const float dy = there.y - here.y;
  track.sxx = (1 - w) * track.sxx + w * gone.sxx + w * (1 - w) * dx * dx;
  track.sxy = (1 - w) * track.sxy + w * gone.sxy + w * (1 - w) * dx * dy;
  track.syy = (1 - w) * track.syy + w * gone.syy + w * (1 - w) * dy * dy;
  // The next tick counts the events since the last one, so their time is noted here.
  if (track.events != state.events) state.last_event = track.stamp;
  if (age_us(gone_state.last_event, state.last_event) > 0) state.last_event = gone_state.last_event;
  track.x = here.x + w * dx;
  track.y = here.y + w * dy;
  track.stamp = now;
  state.kalman.x += w * dx;
  state.kalman.y += w * dy;
  state.mass += gone_mass;
  state.fast_rate_hz += gone_state.fast_rate_hz;
  state.slow_rate_hz += gone_state.slow_rate_hz;
  tracks.contour(survivor).forget_radius();
  state.centre_variance = kInitialCentreVariance;
  Box& sides = tracks.contour(survivor).sides;
  sides = united(sides, tracks.contour(other).sides.moved(dx, dy)).moved(-w * dx, -w * dy);
}

// ---- siblings ----

void find_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now) noexcept {
  TrackState& state = tracks.state(slot);
  const Point here = predicted_mean(tracks[slot], now);
  float nearest = std::numeric_limits<float>::infinity();
  for (const Tracks::Slot other : tracks.active()) {
    if (other == slot || !tracks[other].has_id()) continue;
    const Point there = predicted_mean(tracks[other], now);
    const float distance = length(here.x - there.x, here.y - there.y);
    const float reach = merge_distance(state.extent_px + tracks.state(other).extent_px);
    if (distance > reach || distance >= nearest) continue;
    nearest = distance;
    state.sibling = other;
    state.sibling_generation = tracks[other].generation;
  }
}

void forget_far_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now) noexcept {
  TrackState& state = tracks.state(slot);
  if (state.sibling == kNoSlot) return;
  if (is_sibling(tracks, slot, state.sibling)) {
    constexpr float kMargin_px = 4;
    const Point here = predicted_mean(tracks[slot], now);
    const Point there = predicted_mean(tracks[state.sibling], now);
    const float extents = state.extent_px + tracks.state(state.sibling).extent_px;
    if (length(there.x - here.x, there.y - here.y) <= merge_distance(extents) + kMargin_px) return;
  }
  state.sibling = kNoSlot;
}

}  // namespace asap::inline v0_1::fast
