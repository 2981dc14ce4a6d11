#include "algorithms/fast/foresight.hpp"

#include <algorithm>

#include "algorithms/fast/kalman.hpp"
#include "algorithms/fast/report.hpp"

namespace asap::fast {

bool live_on(Track& track, Life& life, const Tick& tick, const Settings& settings,
             const Frame& frame) noexcept {
  if (!track.has_id()) return false;
  if (live(track, life, tick, settings.life, settings.gate) == Fate::kDies) return false;
  if (is_starved(life)) kalman_starve(track, life.kalman, tick.now, settings.life.velocity_decay_s);
  return is_listed(track, life, settings.life) && !has_left(track, tick.now, frame);
}

void foresee(const Tracks& tracks, const EventClock& clock, const Tick& tick,
             const Settings& settings, const Frame& frame, std::vector<Cluster>& clusters) {
  for (const Tracks::Slot slot : tracks.active()) {
    Track track = tracks[slot];
    Life life = tracks.life(slot);
    if (!live_on(track, life, tick, settings, frame)) continue;
    const PositionError error =
        position_error(track, life.kalman, tracks.contour(slot), tick.now, settings.kalman);
    clusters.push_back(report(track, life, error, clock));
  }
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
}

}  // namespace asap::fast
