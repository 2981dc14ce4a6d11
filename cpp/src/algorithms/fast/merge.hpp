// Merge: two tracks are one object if their relative position stays constant while they travel.
// Fragments of one object keep it, objects that met do not; similar velocities, the usual test,
// fail for newborns. How long they must keep it depends on what they are: a moving object has a
// leading edge of one polarity and a trailing one of the other, a fragment often only one of them.
// One thread, at the tick. O(1) per pair, no allocation.
// Source: own design.
#pragma once

#include "algorithms/fast/pairs.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

struct MergeRule {
  float tolerance_px;  // [mtol]
  float rotation_rad;  // [mrot]
};

// Whether they have kept their relative position for long enough. Updates the keeper's memory.
bool are_one(Tracks& tracks, const Candidate& pair, float dt_s, const MergeRule& rule) noexcept;

// Whether one was confirmed within reach of the other and has not been out of it since: a fragment
// then, not an object that came along.
bool are_siblings(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept;

// Notes the nearest confirmed track within reach of one that is confirmed now.
void find_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now, const PairRule& rule) noexcept;

// Drops the sibling of a track that is gone, or farther away than their reach and 4 px.
void forget_far_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now,
                        const PairRule& rule) noexcept;

// The one of a pair that goes on: the confirmed, the one with the smaller id, with more events.
Tracks::Slot survivor_of(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept;

// Joins their moments, at their positions now, in the survivor. The caller removes the other one.
void merge(Tracks& tracks, Tracks::Slot survivor, Tracks::Slot other, Stamp now) noexcept;

}  // namespace asap::fast
