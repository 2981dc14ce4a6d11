// Pairs of tracks, and which pairs become one. Pairs: tracks whose outlines nearly meet are in
// contact; within a wider reach two tracks may be parts of one object, and a tentative one the tip
// of a large object within the widest. A track keeps the nearest such candidate, a confirmed one up
// to four where one of the two is large. Merge: two tracks are one object if their relative
// position stays constant while they travel. Parts of one object keep it, objects that met do not;
// similar velocities, the usual test, fail for new tracks. The time it takes depends on the edges:
// a moving object has a leading edge of one polarity and a trailing one of the other, a part of an
// object often has only one of them, or is a thin arc or bar. One thread, at the tick.
// Pairs::find() O(n^2) of cheap steps in n tracks, the rest O(1) per pair, O(n) per merge;
// allocates in the constructor only. Source: own design.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

// ---- pairs ----

// Two tracks that may be one object. `keeper` holds their MergeState: of a mixed pair the tentative
// track, else the older one.
struct Candidate {
  Tracks::Slot keeper;
  Tracks::Slot other;
  float dx;  // px, from keeper to other
  float dy;
  float distance_px;
};

class Pairs {
 public:
  explicit Pairs(std::size_t slots);

  // Sets partners, near_confirmed and may_be_fragment of all tracks, and candidates(). Notes the
  // fragments.
  void find(Tracks& tracks, Stamp now) noexcept;

  const std::vector<Candidate>& candidates() const noexcept { return candidates_; }

 private:
  struct Place {
    float x;
    float y;
    float extent;
    Tracks::Slot slot;
    bool has_id;
  };

  // Two places, the first that of the tentative track if one is.
  void compare(Tracks& tracks, std::size_t keeper, std::size_t other) noexcept;

  std::vector<Place> places_;
  std::vector<std::array<Candidate, kMaxCandidates>> nearest_;  // per place; no slot: none
  std::vector<Candidate> candidates_;
};

// ---- merging ----

// Whether a track has a leading and a trailing edge, which fire with opposite polarities.
bool has_both_edges(const Tracks& tracks, Tracks::Slot slot) noexcept;

// Whether the ON events lie on one side of a track and the OFF events on the other, as those of a
// thing that moves do and those of noise do not.
bool has_edges_apart(const Tracks& tracks, Tracks::Slot slot) noexcept;

// Whether the one has a leading edge alone and the other a trailing one.
bool have_opposite_edges(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept;

// Whether the pair has kept its relative position for long enough. Updates the keeper's MergeState.
bool are_one(Tracks& tracks, const Candidate& pair, float dt_s) noexcept;

// The one of a pair that goes on: the confirmed, then the smaller id, then more events.
Tracks::Slot survivor_of(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept;

// Joins the moments of both, at their positions now, in the survivor. The caller removes the other.
void merge(Tracks& tracks, Tracks::Slot survivor, Tracks::Slot other, Stamp now) noexcept;

// ---- siblings ----------------------------------------------------------------------------------

// Tracks that are parts of one object since one of them was confirmed beside the other.

// Sets the sibling of a track that is confirmed now: the nearest confirmed track within reach.
void find_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now) noexcept;

// Removes a sibling that was deleted or is farther away than the reach and 4 px.
void forget_far_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now) noexcept;

}  // namespace asap::inline v0_1::fast
