// What a track is to the outside: a Cluster, predicted for the clock's time. The track has lived up
// to then. Pure function, O(1).
#pragma once

#include <cmath>

#include "algorithms/fast/event_clock.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/position_error.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"
#include "asap/algorithms/cluster.hpp"

namespace asap::fast {

inline Cluster report(const Track& track, const Life& life, const PositionError& error,
                      const EventClock& clock) noexcept {
  const Sight s = sight_of(track, clock.now(), 0, 0);
  return {.id = track.id,
          .x = s.mean_x,
          .y = s.mean_y,
          .vx = track.vx,
          .vy = track.vy,
          .cxx = track.sxx,
          .cxy = track.sxy,
          .cyy = track.syy,
          .size = std::lround(life.mass),
          .t_last = clock.stamp_us(age_us(clock.now(), life.last_event)),
          .pxx = error.xx,
          .pxy = error.xy,
          .pyy = error.yy};
}

}  // namespace asap::fast
