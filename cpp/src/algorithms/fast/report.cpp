// What Engine tells: the listed tracks and shown objects, predicted for a time to which no event
// has come yet. The tracks advance without events: they are starved, no longer listed, or leave the
// frame. All this happens on copies, so that a report changes nothing. Births and merges wait for
// events.
#include <algorithm>
#include <cmath>
#include <functional>

#include "algorithms/fast/engine.hpp"
#include "algorithms/fast/kalman.hpp"

namespace asap::inline v0_1::fast {

namespace {

// The track as a cluster at the clock's time, up to which the track must have been advanced.
Cluster report(const Track& track, const TrackState& state, const EventClock& clock) noexcept {
  const Point mean = predicted_mean(track, clock.now());
  const PositionError error = position_error(track, state, clock.now());
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

// The object with this sum at the clock's time.
TrackedObject report(const ObjectSum& sum, std::int64_t id, std::uint64_t born_us,
                     const EventClock& clock) noexcept {
  return {.id = id,
          .x = sum.x,
          .y = sum.y,
          .vx = sum.vx,
          .vy = sum.vy,
          .left = sum.box.left,
          .top = sum.box.top,
          .width = sum.box.width(),
          .height = sum.box.height(),
          .size = std::lround(sum.mass),
          .t_last = clock.stamp_us(sum.quiet_us),
          .age_us = static_cast<std::int64_t>(clock.now_us() - born_us)};
}

// Advances a track to the tick's time without events. False: it is not listed then.
bool advance_without_events(Track& track, TrackState& state, const Tick& tick,
                            const Settings& settings, const Frame& frame) noexcept {
  if (!track.has_id()) return false;
  if (assess(track, state, tick, settings.lifecycle) == Assessment::kDelete) return false;
  if (is_starved(state)) kalman_without_events(track, state.kalman, tick.now);
  return is_listed(track, state) && !has_left(track, tick.now, frame);
}

}  // namespace

EventClock Engine::clock_at(std::int64_t t_us) const noexcept {
  EventClock clock = clock_;
  clock.advance_to(t_us);
  return clock;
}

// Calls visit(slot, track, state) with copies of the tracks that `chosen` accepts by their slot and
// that are listed at the clock's time.
template <class Chosen, class Visit>
void Engine::for_each_listed(const EventClock& clock, Chosen&& chosen, Visit&& visit) const {
  const std::uint64_t elapsed_us = clock.now_us() - tracks_us_;
  if (elapsed_us > kSilence_us) return;
  const Tick tick(clock.now(), seconds(elapsed_us), noise_hz_);
  for (const Slot slot : tracks_.active()) {
    if (!chosen(slot)) continue;
    Track track = tracks_[slot];
    TrackState state = tracks_.state(slot);
    if (advance_without_events(track, state, tick, settings_, frame_)) visit(slot, track, state);
  }
}

void Engine::read(std::int64_t t_us, std::vector<Cluster>& clusters) const {
  clusters.clear();
  const EventClock clock = clock_at(t_us);
  for_each_listed(
      clock, [](Slot) { return true; },
      [&](Slot, const Track& track, const TrackState& state) {
        clusters.push_back(report(track, state, clock));
      });
  std::ranges::sort(clusters, {}, &Cluster::id);
}

void Engine::read(std::int64_t t_us, std::vector<TrackedObject>& objects) const {
  objects.clear();
  const EventClock clock = clock_at(t_us);
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (!objects_.is_shown(i)) continue;
    const ObjectSum sum = sum_of(i, clock);
    if (sum.parts == 0 || sum.is_quiet()) continue;
    objects.push_back(report(sum, objects_.id(i), objects_.born_us(i), clock));
  }
  std::ranges::sort(objects, {}, &TrackedObject::id);
}

ObjectSum Engine::sum_of(std::size_t object, const EventClock& clock) const {
  ObjectSum sum;
  for_each_listed(
      clock, [&](Slot slot) { return objects_.object_of(slot, tracks_[slot]) == object; },
      [&](Slot slot, const Track& track, const TrackState& state) {
        sum.add(slot, track, state, tracks_.contour(slot), clock.now());
      });
  return sum;
}

std::int32_t Engine::object_of(std::int32_t cluster) const noexcept {
  if (cluster == kNoId) return kNoId;
  for (const Slot slot : tracks_.active()) {
    const Track& track = tracks_[slot];
    if (!track.has_id() || track.id != cluster) continue;
    const std::size_t object = objects_.object_of(slot, track);
    const bool is_part = object != Objects::kNone && objects_.is_shown(object);
    return is_part ? static_cast<std::int32_t>(objects_.id(object)) : kNoId;
  }
  return kNoId;
}

void Engine::read_parts(std::int64_t id, std::vector<Cluster>& clusters) const {
  clusters.clear();
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (!objects_.is_shown(i) || objects_.id(i) != id || sum_of(i, clock_).is_quiet()) continue;
    for_each_listed(
        clock_, [&](Slot slot) { return objects_.object_of(slot, tracks_[slot]) == i; },
        [&](Slot, const Track& track, const TrackState& state) {
          clusters.push_back(report(track, state, clock_));
        });
  }
  std::ranges::sort(clusters, [](const Cluster& a, const Cluster& b) {
    return a.size != b.size ? a.size > b.size : a.id < b.id;
  });
}

}  // namespace asap::inline v0_1::fast
