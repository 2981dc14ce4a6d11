// What the tracker reports: the listed tracks as clusters, predicted for a time to which no event
// has come yet. The tracks advance without events: they are starved, no longer listed, or leave the
// frame. All this happens on copies, so that a report changes nothing. Births and merges wait for
// events. One thread. O(n log n) in n tracks; allocates only where the list must grow.
// Source: own design; the rules are the tick's (lifecycle.hpp, kalman.hpp).
#pragma once

#include <vector>

#include "algorithms/fast/kalman.hpp"
#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/settings.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"
#include "asap/algorithms/cluster_tracker.hpp"

namespace asap::fast {

// The track as a cluster at the clock's time, up to which the track must have been advanced.
Cluster report(const Track& track, const TrackState& state, const PositionError& error,
               const EventClock& clock) noexcept;

// Advances a track to the tick's time without events. False: it is not listed then.
bool advance_without_events(Track& track, TrackState& state, const Tick& tick,
                            const Settings& settings, const Frame& frame) noexcept;

// Appends the clusters that are listed at `tick`, which is the clock's time, sorted by id.
void predict_clusters(const Tracks& tracks, const EventClock& clock, const Tick& tick,
                      const Settings& settings, const Frame& frame, std::vector<Cluster>& clusters);

}  // namespace asap::fast
