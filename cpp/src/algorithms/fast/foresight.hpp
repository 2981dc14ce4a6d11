// Foresight: the clusters of a time to which no event has come yet. The tracks live on without
// events, starve, hide and leave the frame; all on copies, so that asking changes nothing. Births
// and merges wait for events. One thread. O(n log n) in n tracks; allocates only where the list
// must grow.
// Source: own design; the rules are the tick's (lifecycle.hpp, kalman.hpp).
#pragma once

#include <vector>

#include "algorithms/fast/event_clock.hpp"
#include "algorithms/fast/frame.hpp"
#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/settings.hpp"
#include "algorithms/fast/track.hpp"
#include "asap/algorithms/cluster.hpp"

namespace asap::fast {

// Takes a track on to the tick's time. False: it will not be listed.
bool live_on(Track& track, Life& life, const Tick& tick, const Settings& settings,
             const Frame& frame) noexcept;

// Adds the clusters that are listed at `tick`, which is the clock's time, sorted by id.
void foresee(const Tracks& tracks, const EventClock& clock, const Tick& tick,
             const Settings& settings, const Frame& frame, std::vector<Cluster>& clusters);

}  // namespace asap::fast
