#include "algorithms/fast/engine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/kalman.hpp"
#include "algorithms/fast/pairs.hpp"
#include "algorithms/fast/track.hpp"
#include "algorithms/fast/update.hpp"

namespace asap::inline v0_1::fast {

namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
constexpr std::uint64_t kNoisePeriod_us = 8'000;
constexpr std::uint64_t kFirstNoise_us = 2'000;  // from the start: enough to see heavy noise
constexpr float kPriorNoise_hz = 0.5F;  // per pixel; the least until 8 ms are measured; 0.2 to 2

}  // namespace

Engine::Engine(const ClusterTrackerConfig& config)
    : config_(config),
      settings_(config),
      frame_{static_cast<std::uint32_t>(config.width), static_cast<std::uint32_t>(config.height)},
      map_(config.width, config.height),
      support_(config.width, config.height),
      owners_(map_),
      births_(map_),
      noise_(config.width, config.height),
      coarse_(config.width, config.height, static_cast<std::size_t>(config.slots)),
      tracks_(static_cast<std::size_t>(config.slots)),
      pairs_(static_cast<std::size_t>(config.slots)),
      parts_(map_),
      halves_(map_),
      objects_(static_cast<std::size_t>(config.slots)) {
  forget();
}

void Engine::reset() noexcept {
  settings_ = Settings(config_);
  gamma_ = {};
  filtered_upstream_ = false;
  clock_ = {};
  forget();
  counters_ = {};
  next_id_ = 0;
}

void Engine::set_gamma(double gamma, bool filtered_upstream) noexcept {
  gamma_.tell(gamma);
  if (filtered_upstream == filtered_upstream_) return;
  filtered_upstream_ = filtered_upstream;
  settings_.set_gamma(config_, gamma_.value(), filtered_upstream);
}

// All that events have left, but for the ids.
void Engine::forget() noexcept {
  support_.clear(clock_.now());
  owners_.clear(clock_.now());
  births_.clear(clock_.now());
  noise_.clear();
  coarse_.clear();
  tracks_.clear();
  objects_.clear();
  has_confirmed_ = false;
  next_split_ = 0;
  noise_hz_ = 0;
  due_us_ = clock_.now_us();
  due_stamp_us_ = std::numeric_limits<std::int64_t>::min();
}

void Engine::start() noexcept {
  started_us_ = tracks_us_ = pairs_us_ = noise_us_ = objects_us_ = clock_.now_us();
  due_us_ = clock_.now_us() + kTick_us;
  tracks_are_due_ = true;
  settings_.update.far_weight = far_weight(noise_hz_);
  birth_threshold_ = kNever;
  widest_radius_px_ = settings_.gate.birth_radius_px;
  support_window_us_ = settings_.support_window_us;
}

// ---- per event ----

// Advances to an event that starts the tracker, makes a tick due or goes back.
void Engine::advance(std::int64_t t_us) noexcept {
  const bool first = !clock_.started();
  clock_.advance(t_us);
  if (first) start();
  tick_if_due();
}

inline std::int32_t Engine::process(const Event& event) noexcept {
  if (event.x >= frame_.width || event.y >= frame_.height) [[unlikely]] {
    ++counters_.rejected;
    return kNoId;
  }
  if (event.t < clock_.latest_us() || event.t >= due_stamp_us_) [[unlikely]] {
    advance(event.t);
  } else {
    clock_.step_to(event.t);
  }
  const Stamp now = clock_.now();
  bool may_begin = true;
  if (settings_.uses_support && !support_.touch(event.x, event.y, now, support_window_us_)) {
    noise_.count(event.x, event.y);
    ++counters_.unsupported;
    if (settings_.rejects_unsupported) return kNoId;
    may_begin = settings_.begins_unsupported;
  }
  const std::size_t index = map_.cell(event.x, event.y);
  OwnerGrid::Cell& cell = owners_[index];
  Track& track = tracks_[cell.slot];
  if (cell.generation == track.generation && age_us(now, cell.stamp) <= kLink_us) {
    const Innovation nu = innovation_of(track, now, event);
    if (accepts(track, nu)) {
      if (track.partners > 0) [[unlikely]]
        return assign(cell.slot, cell, event, now);
      cell.stamp = now;
      cell.on = event.p > 0;
      update_mean(track, tracks_.contour(cell.slot), nu, now, cell.on, settings_.update,
                  directions_);
      return track.id;
    }
  }
  return associate(event, index, now, may_begin);
}

void Engine::process(EventSpan events, std::int32_t* labels) noexcept {
  if (gamma_.take(events.size())) {
    settings_.set_gamma(config_, gamma_.value(), filtered_upstream_);
  }
  for (const Event& event : events) {
    const std::int32_t id = process(event);
    if (labels != nullptr) *labels++ = id;
  }
}

// Assigns the event to the slot or, in contact, to a partner whose outline it fits better.
std::int32_t Engine::assign(Slot slot, OwnerGrid::Cell& cell, const Event& event,
                            Stamp now) noexcept {
  const bool in_contact = tracks_[slot].partners > 0;
  Taker taker{slot, innovation_of(tracks_[slot], now, event)};
  if (in_contact) taker = associate_in_contact(tracks_, taker, now, event, directions_);
  Track& track = tracks_[taker.slot];
  cell = {now, track.generation, static_cast<std::uint8_t>(taker.slot), event.p > 0};
  Contour& contour = tracks_.contour(taker.slot);
  if (in_contact) {
    update_in_contact(track, contour, taker.nu, now, cell.on, settings_.update, directions_);
  } else {
    update_mean(track, contour, taker.nu, now, cell.on, settings_.update, directions_);
  }
  return track.id;
}

std::int32_t Engine::associate(const Event& event, std::size_t cell, Stamp now,
                               bool may_begin) noexcept {
  Slot slot = nearest_track(event, cell, now);
  if (slot == Tracks::kNone && may_begin) slot = try_birth(event, cell, now);
  if (slot == Tracks::kNone) return kNoId;
  return assign(slot, owners_[cell], event, now);
}

// The nearest track whose gate accepts the event. A tentative track only if there is no other.
Tracks::Slot Engine::nearest_track(const Event& event, std::size_t cell, Stamp now) noexcept {
  Slot best = Tracks::kNone;
  float min = 1;
  bool has_id = false;
  const auto consider = [&](Slot slot) {
    const Track& track = tracks_[slot];
    if (has_id && !track.has_id()) return;
    const Innovation nu = innovation_of(track, now, event);
    const float value = gate_value(track, nu);
    const bool outranks = track.has_id() && !has_id && value <= 1;
    if (!outranks && !(value < min || (best == Tracks::kNone && value <= 1))) return;
    best = slot;
    min = value;
    has_id = track.has_id();
  };
  coarse_.for_each_around(event.x, event.y, consider);
  if (best != Tracks::kNone) return best;
  map_.for_each_neighbour(cell, [&](std::size_t neighbour) {
    const OwnerGrid::Cell& owner = owners_[neighbour];
    if (owner.generation != tracks_[owner.slot].generation) return;
    if (age_us(now, owner.stamp) <= kLink_us) consider(owner.slot);
  });
  return best;
}

Tracks::Slot Engine::try_birth(const Event& event, std::size_t cell, Stamp now) noexcept {
  if (!settings_.uses_support) noise_.count(event.x, event.y);
  if (births_.count(cell, now) < birth_threshold_) return Tracks::kNone;
  const Slot slot = begin_track(static_cast<float>(event.x), static_cast<float>(event.y));
  if (slot != Tracks::kNone) births_.forget(cell);
  return slot;
}

Tracks::Slot Engine::begin_track(float x, float y) noexcept {
  const Slot slot = tracks_.create(x, y, clock_.now());
  if (slot == Tracks::kNone) {
    ++counters_.refused;
    return slot;
  }
  tracks_.state(slot).young_radius_px = settings_.gate.birth_radius_px;  // it may have neighbours
  shape_birth_gate(tracks_[slot], settings_.gate.birth_radius_px);
  tracks_.contour(slot).set_memory(settings_.update.mean_events);
  tracks_.state(slot).age_s = -seconds(clock_.now_us() - tracks_us_);
  coarse_.place(slot, x, y);
  return slot;
}

// ---- per tick ----

void Engine::advance_to(std::int64_t t_us) noexcept {
  if (!clock_.started()) return;
  clock_.advance_to(t_us);
  tick_if_due();
}

void Engine::tick_if_due() noexcept {
  if (clock_.now_us() >= due_us_) tick();
  due_stamp_us_ = clock_.stamp_us(static_cast<std::int64_t>(clock_.now_us() - due_us_));
}

// Does half of the work, all of it after a missed tick, or begins anew after a long silence.
void Engine::tick() noexcept {
  const std::uint64_t since_us = clock_.now_us() - (due_us_ - kTick_us);
  if (since_us > kSilence_us) {
    forget();
    return start();
  }
  const bool late = 2 * since_us > 5 * kTick_us;
  if (late || tracks_are_due_) update_tracks();
  if (late || !tracks_are_due_) update_pairs_and_noise();
  update_objects();
  tracks_are_due_ = !tracks_are_due_;
  due_us_ = clock_.now_us() + kTick_us;
}

void Engine::update_tracks() noexcept {
  const std::uint64_t elapsed_us = clock_.now_us() - tracks_us_;
  tracks_us_ = clock_.now_us();
  const auto& active = tracks_.active();
  const Tick tick(clock_.now(), seconds(elapsed_us), noise_hz_);
  for (std::size_t i = 0; i < active.size();) {
    const Slot slot = active[i];
    if (update_track(slot, tick)) {
      ++i;
    } else {
      remove(slot);
    }
  }
}

// False: the track is to be deleted.
bool Engine::update_track(Slot slot, const Tick& tick) noexcept {
  Track& track = tracks_[slot];
  TrackState& state = tracks_.state(slot);
  if (track.partners == 0) tracks_.contour(slot).shrink_sides(track.events - state.events);
  const Assessment assessment = assess(track, state, tick, settings_.lifecycle);
  if (assessment == Assessment::kDelete || has_left(track, tick.now, frame_)) return false;
  if (assessment == Assessment::kConfirm) confirm(slot);

  if (track.has_id() && is_starved(state)) {
    kalman_without_events(track, state.kalman, tick.now);
    if (!is_listed(track, state)) return_to_last_seen(track, state);
  }
  if (state.starved_s == 0) record_motion(track, state, tick);
  Contour& contour = tracks_.contour(slot);
  update_centre_variance(track, state, tick.dt_s);
  const std::uint32_t longest = settings_.update.mean_events;
  kalman_update(track, state.kalman, contour.variance,
                track.partners > 0 ? longest : std::min(state.mean_events, longest));
  state.mean_events = size_memory(track, settings_.update);
  contour.set_memory(state.mean_events);
  track.mean_weight = mean_weight(track, contour);
  contour.outline_weight = 2 * (1 - track.mean_weight);

  const float extent2 = largest_variance(track);
  state.extent_px = std::sqrt(extent2);
  if (track.partners == 0) record_extent(state, extent2, tick);
  update_gate(track, state, settings_.gate, widest_radius_px_);
  const bool unresolved = looks_unresolved(track, contour, state, tick.noise_hz);
  state.unresolved_s = unresolved ? state.unresolved_s + tick.dt_s : 0;
  const Point mean = predicted_mean(track, tick.now);
  coarse_.place(slot, mean.x, mean.y);
  return true;
}

void Engine::confirm(Slot slot) noexcept {
  Track& track = tracks_[slot];
  track.phase = Phase::kConfirmed;
  has_confirmed_ = true;
  track.id = next_id_++;
  find_sibling(tracks_, slot, clock_.now());
}

// Every few ms, and at once for a new track.
void Engine::update_objects() noexcept {
  constexpr std::uint64_t kPeriod_us = 5'000;
  if (!has_confirmed_ && clock_.now_us() - objects_us_ < kPeriod_us) return;
  objects_.update(tracks_, noise_, clock_.now_us(), next_id_);
  objects_us_ = clock_.now_us();
  has_confirmed_ = false;
}

void Engine::remove(Slot slot) noexcept {
  coarse_.remove(slot);
  tracks_.remove(slot);
}

void Engine::update_pairs_and_noise() noexcept {
  const std::uint64_t now_us = clock_.now_us();
  const std::uint64_t elapsed_us = now_us - pairs_us_;
  pairs_us_ = now_us;
  const bool starts = now_us - started_us_ < kNoisePeriod_us;
  if (now_us - noise_us_ >= (starts ? kFirstNoise_us : kNoisePeriod_us)) measure_noise();
  pairs_.find(tracks_, clock_.now());
  merge_pairs(seconds(elapsed_us));
  split_next();
  support_.scrub(clock_.now(), elapsed_us);
  owners_.scrub(clock_.now(), elapsed_us);
  births_.scrub(clock_.now(), elapsed_us);
}

void Engine::measure_noise() noexcept {
  noise_.update(seconds(clock_.now_us() - noise_us_));
  noise_us_ = clock_.now_us();
  const auto window_s = [&] { return 1e-6F * static_cast<float>(support_window_us_); };
  noise_hz_ = noise_.rate_hz();
  if (settings_.uses_support) noise_hz_ = total_noise(noise_hz_, window_s());
  support_window_us_ =
      support_window_us(noise_hz_, settings_.support_window_us, settings_.longest_window_us);
  if (settings_.rejects_unsupported) noise_hz_ = supported_noise(noise_hz_, window_s());
  if (noise_us_ - started_us_ < kNoisePeriod_us) noise_hz_ = std::max(noise_hz_, kPriorNoise_hz);
  settings_.update.far_weight = far_weight(noise_hz_);
  widest_radius_px_ = widest_radius(settings_.gate, noise_hz_);
  birth_threshold_ = settings_.birth_threshold(noise_hz_);
}

void Engine::merge_pairs(float dt_s) noexcept {
  for (const Slot slot : tracks_.active()) {
    forget_far_sibling(tracks_, slot, clock_.now());
  }
  for (const Candidate& pair : pairs_.candidates()) {
    // One of them was removed by a merge in this tick.
    if (tracks_[pair.keeper].phase == Phase::kFree || tracks_[pair.other].phase == Phase::kFree)
      continue;
    if (!are_one(tracks_, pair, dt_s)) continue;
    const Slot survivor = survivor_of(tracks_, pair.keeper, pair.other);
    const Slot other = survivor == pair.keeper ? pair.other : pair.keeper;
    merge(tracks_, survivor, other, clock_.now());
    remove(other);
  }
}

// One track per tick, in turn.
void Engine::split_next() noexcept {
  const auto& active = tracks_.active();
  for (std::size_t tries = 0; tries < active.size(); ++tries) {
    next_split_ = next_split_ + 1 < active.size() ? next_split_ + 1 : 0;
    const Slot slot = active[next_split_];
    if (is_unresolved(tracks_.state(slot))) return halve(slot);
    if (extent_has_grown(tracks_[slot], tracks_.state(slot), settings_.dense_per_px)) {
      return split(slot);
    }
  }
}

void Engine::split(Slot slot) noexcept {
  const Stamp now = clock_.now();
  const auto parts = parts_.find(owners_, tracks_, slot, now, kLink_us);
  const Part* kept = part_at_prediction(parts, tracks_[slot], tracks_.state(slot), now);
  if (kept == nullptr) return;
  float given = 0;
  for (const auto& part : parts) {
    if (part.distance(*kept) < settings_.gate.birth_radius_px) continue;
    const float share = share_of(part, parts);
    if (begin_part(slot, part, share) != Tracks::kNone) given += share;
  }
  if (given == 0) return;
  restart_at_part(tracks_, slot, *kept, 1 - given, now);
}

void Engine::halve(Slot slot) noexcept {
  const auto halves = halves_.find(owners_, tracks_, slot, clock_.now());
  if (!have_parted(tracks_.state(slot), halves, settings_.gate.birth_radius_px)) return;
  const float share = share_of(halves[1], halves);
  const Slot child = begin_part(slot, halves[1], share);
  if (child == Tracks::kNone) return;
  restart_at_part(tracks_, slot, halves[0], 1 - share, clock_.now());
  confirm_child(tracks_, slot, child, share, settings_.gate);
  tracks_[child].id = next_id_++;
  has_confirmed_ = true;
}

Tracks::Slot Engine::begin_part(Slot parent, const Part& part, float share) noexcept {
  const Slot slot = begin_track(part.x, part.y);
  if (slot == Tracks::kNone) return slot;
  begin_at_part(tracks_, parent, slot, part, share);
  owners_.give(part.cells, slot, tracks_[slot].generation);
  return slot;
}

}  // namespace asap::inline v0_1::fast
