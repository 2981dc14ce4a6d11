// Siblings: tracks that are parts of one object since one of them was confirmed beside the other.
// One thread, at the tick. O(n) in n tracks; no allocation. Source: own design.
#pragma once

#include "algorithms/fast/merge.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

// Whether one was confirmed within reach of the other and has not left it since. It is then a part
// of the same object, and not an object that came along.
bool are_siblings(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept;

// Sets the sibling of a track that is confirmed now: the nearest confirmed track within reach.
void find_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now, const PairRule& rule) noexcept;

// Removes a sibling that was deleted or is farther away than the reach and 4 px.
void forget_far_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now,
                        const PairRule& rule) noexcept;

// The siblings of a track that has become part of another are siblings of that one.
void inherit_siblings(Tracks& tracks, Tracks::Slot survivor, Tracks::Slot other) noexcept;

}  // namespace asap::fast
