// Revival: a newborn that stands where a lost object must have come out is that object and takes
// over its id. An object that stood still is found where it stopped, by its own gate; one that went
// on behind something else comes out where its velocity has carried it meanwhile, and only this
// can know it. One thread, when a track is confirmed. O(n), no allocation.
// Source: own design.
#pragma once

#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

// Remembers position and usual velocity of a track that sees events.
void remember_motion(const Track& track, Life& life, const Tick& tick) noexcept;

// Puts a track that is not listed any more to where it saw its last events: there its gate finds an
// object that stopped.
void wait_where_seen(Track& track, Life& life) noexcept;

// The unlisted track that the newborn continues, or kNone.
Tracks::Slot lost_track_of(const Tracks& tracks, Tracks::Slot newborn, Stamp now,
                           const LifeRule& rule) noexcept;

}  // namespace asap::fast
