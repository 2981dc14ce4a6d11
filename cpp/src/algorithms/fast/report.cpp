#include "algorithms/fast/report.hpp"

#include <algorithm>
#include <cmath>

namespace asap::fast {

Cluster report(const Track& track, const TrackState& state, const PositionError& error,
               const EventClock& clock) noexcept {
  const Point mean = predicted_mean(track, clock.now());
  return {.id = track.id,
          .x = mean.x,
          .y = mean.y,
          .vx = track.vx,
          .vy = track.vy,
          .cxx = track.sxx,
          .cxy = track.sxy,
          .cyy = track.syy,
          .size = std::lround(state.mass),
          .t_last = clock.stamp_us(age_us(clock.now(), state.last_event)),
          .pxx = error.xx,
          .pxy = error.xy,
          .pyy = error.yy};
}

bool advance_without_events(Track& track, TrackState& state, const Tick& tick,
                            const Settings& settings, const Frame& frame) noexcept {
  if (!track.has_id()) return false;
  if (assess(track, state, tick, settings.lifecycle, settings.gate) == Assessment::kDelete)
    return false;
  if (is_starved(state))
    kalman_without_events(track, state.kalman, tick.now, settings.lifecycle.velocity_decay_s);
  return is_listed(track, state, settings.lifecycle) && !has_left(track, tick.now, frame);
}

void predict_clusters(const Tracks& tracks, const EventClock& clock, const Tick& tick,
                      const Settings& settings, const Frame& frame,
                      std::vector<Cluster>& clusters) {
  for (const Tracks::Slot slot : tracks.active()) {
    Track track = tracks[slot];
    TrackState state = tracks.state(slot);
    if (!advance_without_events(track, state, tick, settings, frame)) continue;
    const PositionError error =
        position_error(track, state.kalman, tracks.contour(slot), tick.now, settings.kalman);
    clusters.push_back(report(track, state, error, clock));
  }
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
}

}  // namespace asap::fast
