#include "algorithms/fast/revival.hpp"

#include "algorithms/fast/gate.hpp"

namespace asap::fast {
namespace {

// The first part that comes out lies ahead of the centre, and the velocity is not exact.
constexpr float kTolerance_px = 12;
constexpr float kTolerancePerWay = 0.35F;

}  // namespace

void remember_motion(const Track& track, Life& life, const Tick& tick) noexcept {
  const Sight s = sight_of(track, tick.now, 0, 0);
  life.seen_x = s.mean_x;
  life.seen_y = s.mean_y;
  const float weight = 1 - tick.motion_decay;
  life.usual_vx += weight * (track.vx - life.usual_vx);
  life.usual_vy += weight * (track.vy - life.usual_vy);
}

void wait_where_seen(Track& track, Life& life) noexcept {
  track.x = life.kalman.x = life.seen_x;
  track.y = life.kalman.y = life.seen_y;
  track.vx = 0;
  track.vy = 0;
}

Tracks::Slot lost_track_of(const Tracks& tracks, Tracks::Slot newborn, Stamp now,
                           const LifeRule& rule) noexcept {
  Tracks::Slot best = Tracks::kNone;
  float least = 1;
  for (const Tracks::Slot slot : tracks.active()) {
    const Life& life = tracks.life(slot);
    if (slot == newborn || !tracks[slot].has_id() || is_listed(tracks[slot], life, rule)) continue;
    const float way_x = life.usual_vx * life.starved_s;
    const float way_y = life.usual_vy * life.starved_s;
    const Sight s = sight_of(tracks[newborn], now, life.seen_x + way_x, life.seen_y + way_y);
    const float tolerance = kTolerance_px + kTolerancePerWay * length(way_x, way_y);
    const float miss = length(s.dx, s.dy) / tolerance;
    if (miss >= least) continue;
    least = miss;
    best = slot;
  }
  return best;
}

}  // namespace asap::fast
