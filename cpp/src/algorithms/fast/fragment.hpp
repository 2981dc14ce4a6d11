// Fragment: what the gate of a large object misses, the tips of a star or the ends of a bar, is
// born as a cluster of its own, and once confirmed takes the object's events from it in contact. So
// a newborn that lies in the widened gate of a grown cluster and is small beside it waits, until it
// has become one with it, or has left. Not beside a cluster that touches another object: out of two
// objects that were taken for one, the second comes as a newborn too.
// One thread, at the tick. O(partners), no allocation.
// Source: own design.
#pragma once

#include "algorithms/fast/track.hpp"

namespace asap::fast {

// Whether the tentative `newborn` is to wait for the confirmed `grown`; px from one to the other.
bool may_be_fragment(const Tracks& tracks, Tracks::Slot newborn, Tracks::Slot grown, float dx,
                     float dy) noexcept;

}  // namespace asap::fast
