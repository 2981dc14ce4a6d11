#include "algorithms/fast/engine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/fast/contact.hpp"
#include "algorithms/fast/foresight.hpp"
#include "algorithms/fast/kalman.hpp"
#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/merge.hpp"
#include "algorithms/fast/position_error.hpp"
#include "algorithms/fast/revival.hpp"

namespace asap::fast {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
constexpr std::uint64_t kNoisePeriod_us = 8'000;
// Silence after which no cluster may live, whatever the parameters: stamps grow ambiguous.
constexpr std::uint64_t kSilence_us = std::uint64_t{1} << 28;

float seconds(std::uint64_t us) noexcept { return 1e-6F * static_cast<float>(us); }

std::int8_t sign_of(const Event& event) noexcept { return event.p > 0 ? 1 : -1; }

std::uint32_t longest_memory(const ClusterTrackerConfig& config) noexcept {
  return static_cast<std::uint32_t>(std::max(config.mean_events, config.covariance_events));
}

}  // namespace

Engine::Engine(const ClusterTrackerConfig& config)
    : config_(config),
      settings_(config),
      frame_{static_cast<std::uint32_t>(config.width), static_cast<std::uint32_t>(config.height)},
      map_(config.width, config.height, config.cell_px),
      support_(config.width, config.height),
      owners_(map_),
      orphans_(map_, settings_.seed_s),
      noise_(config.width, config.height),
      coarse_(config.width, config.height, static_cast<std::size_t>(config.slots)),
      tracks_(static_cast<std::size_t>(config.slots)),
      pairs_(static_cast<std::size_t>(config.slots)),
      parts_(map_),
      halves_(map_),
      reciprocals_(longest_memory(config)) {
  clear_maps();
}

void Engine::reset() noexcept {
  settings_ = Settings(config_);
  clock_ = {};
  clear_maps();
  noise_.clear();
  coarse_.clear();
  tracks_.clear();
  counters_ = {};
  noise_hz_ = 0;
  next_id_ = 0;
}

void Engine::set_keep(double gamma, bool filtered_upstream) noexcept {
  settings_.set_keep(config_, gamma, filtered_upstream);
}

void Engine::clear_maps() noexcept {
  support_.clear(clock_.now());
  owners_.clear(clock_.now());
  orphans_.clear(clock_.now());
}

void Engine::start() noexcept {
  started_us_ = clusters_us_ = frame_us_ = noise_us_ = clock_.now_us();
  next_tick_ = clock_.now() + static_cast<Stamp>(settings_.tick_us);
  clusters_are_due_ = true;
  birth_threshold_ = kNever;
  support_window_us_ = settings_.support_window_us;
}

// ---- per event ----

void Engine::process(EventSpan events, std::int32_t* labels) noexcept {
  if (labels == nullptr) {
    for (const Event& event : events) process(event);
  } else {
    for (const Event& event : events) *labels++ = process(event);
  }
}

std::int32_t Engine::process(const Event& event) noexcept {
  if (event.x >= frame_.width || event.y >= frame_.height) [[unlikely]] {
    ++counters_.rejected;
    return kNoId;
  }
  const bool first = !clock_.started();
  clock_.advance(event.t);
  if (first) [[unlikely]]
    start();
  const Stamp now = clock_.now();
  if (age_us(now, next_tick_) >= 0) [[unlikely]]
    tick();

  if (settings_.asks_support && !support_.touch(event.x, event.y, now, support_window_us_)) {
    noise_.count(event.x, event.y);
    ++counters_.unsupported;
    if (settings_.rejects) return kNoId;
  }
  const std::size_t index = map_.cell(event.x, event.y);
  OwnerGrid::Cell& cell = owners_[index];
  Track& track = tracks_[cell.slot];
  if (cell.generation == track.generation && age_us(now, cell.stamp) <= settings_.link_us) {
    const Sight s = sight_of(track, now, static_cast<float>(event.x), static_cast<float>(event.y));
    if (gate_value(track, s) <= 1) {
      if (track.partners > 0) [[unlikely]]
        return give(cell.slot, cell, event, now);
      cell.stamp = now;
      cell.sign = sign_of(event);
      take(track, tracks_.contour(cell.slot), s, now, sign_of(event), settings_.update,
           reciprocals_, directions_);
      return track.id;
    }
  }
  return search(event, index, now);
}

// Hands the event to the slot or, in contact, to the one of its partners that it fits better.
std::int32_t Engine::give(Slot slot, OwnerGrid::Cell& cell, const Event& event,
                          Stamp now) noexcept {
  const auto x = static_cast<float>(event.x);
  const auto y = static_cast<float>(event.y);
  const bool in_contact = tracks_[slot].partners > 0;
  if (in_contact) {
    slot = winner_of(tracks_, slot, now, x, y, settings_.update.contour, settings_.contact,
                     directions_);
  }
  Track& track = tracks_[slot];
  cell = {now, track.generation, static_cast<std::uint8_t>(slot), sign_of(event)};
  const Sight s = sight_of(track, now, x, y);
  if (in_contact) {
    take_in_contact(track, tracks_.contour(slot), s, now, sign_of(event), settings_.update,
                    settings_.contact, reciprocals_, directions_);
  } else {
    take(track, tracks_.contour(slot), s, now, sign_of(event), settings_.update, reciprocals_,
         directions_);
  }
  return track.id;
}

std::int32_t Engine::search(const Event& event, std::size_t cell, Stamp now) noexcept {
  Slot slot = nearest_around(event, cell, now);
  if (slot == Tracks::kNone) slot = try_birth(event, cell, now);
  if (slot == Tracks::kNone) return kNoId;
  return give(slot, owners_[cell], event, now);
}

// The nearest of the clusters whose gate takes the event; a tentative one only if there is no
// other.
Tracks::Slot Engine::nearest_around(const Event& event, std::size_t cell, Stamp now) noexcept {
  Slot best = Tracks::kNone;
  float least = 1;
  bool has_id = false;
  const auto consider = [&](Slot slot) {
    const Track& track = tracks_[slot];
    if (has_id && !track.has_id()) return;
    const Sight s = sight_of(track, now, static_cast<float>(event.x), static_cast<float>(event.y));
    const float value = gate_value(track, s);
    const bool outranks = track.has_id() && !has_id && value <= 1;
    if (!outranks && !(value < least || (best == Tracks::kNone && value <= 1))) return;
    best = slot;
    least = value;
    has_id = track.has_id();
  };
  coarse_.for_each_around(event.x, event.y, consider);
  if (best != Tracks::kNone) return best;
  map_.for_each_neighbour(cell, [&](std::size_t neighbour) {
    const OwnerGrid::Cell& owner = owners_[neighbour];
    if (owner.generation != tracks_[owner.slot].generation) return;
    if (age_us(now, owner.stamp) <= settings_.link_us) consider(owner.slot);
  });
  return best;
}

Tracks::Slot Engine::try_birth(const Event& event, std::size_t cell, Stamp now) noexcept {
  if (!settings_.asks_support) noise_.count(event.x, event.y);
  if (orphans_.count(cell, now) < birth_threshold_) return Tracks::kNone;
  const Slot slot = begin_track(static_cast<float>(event.x), static_cast<float>(event.y));
  if (slot != Tracks::kNone) orphans_.forget(cell);
  return slot;
}

Tracks::Slot Engine::begin_track(float x, float y) noexcept {
  const Slot slot = tracks_.create(x, y, clock_.now());
  if (slot == Tracks::kNone) {
    ++counters_.refused;
    return slot;
  }
  shape_birth_gate(tracks_[slot], settings_.gate);
  tracks_.life(slot).age_s = -seconds(clock_.now_us() - clusters_us_);
  coarse_.place(slot, x, y);
  return slot;
}

// ---- per tick ----

void Engine::advance_to(std::int64_t t_us) noexcept {
  if (!clock_.started()) return;
  clock_.advance_to(t_us);
  if (age_us(clock_.now(), next_tick_) >= 0 ||
      clock_.now_us() - std::max(clusters_us_, frame_us_) > kSilence_us) {
    tick();
  }
}

// Half of the work; all of it when a tick was missed.
void Engine::tick() noexcept {
  const std::uint64_t since_us = clock_.now_us() - std::max(clusters_us_, frame_us_);
  const bool late = 2 * since_us > 5 * static_cast<std::uint64_t>(settings_.tick_us);
  if (late || clusters_are_due_) tend_clusters();
  if (late || !clusters_are_due_) tend_frame();
  clusters_are_due_ = !clusters_are_due_;
  next_tick_ = clock_.now() + static_cast<Stamp>(settings_.tick_us);
}

void Engine::tend_clusters() noexcept {
  const std::uint64_t elapsed_us = clock_.now_us() - clusters_us_;
  clusters_us_ = clock_.now_us();
  const auto& active = tracks_.active();
  if (elapsed_us > kSilence_us) {
    while (!active.empty()) remove(active.back());
    return;
  }
  const Tick tick(clock_.now(), seconds(elapsed_us), noise_hz_, settings_.life);
  for (std::size_t i = 0; i < active.size();) {
    const Slot slot = active[i];
    if (tend(slot, tick)) {
      ++i;
    } else {
      remove(slot);
    }
  }
}

// False: the track dies.
bool Engine::tend(Slot slot, const Tick& tick) noexcept {
  Track& track = tracks_[slot];
  Life& life = tracks_.life(slot);
  const Fate fate = live(track, life, tick, settings_.life, settings_.gate);
  if (fate == Fate::kDies || has_left(track, tick.now, frame_)) return false;
  if (fate == Fate::kConfirmed) confirm(slot);

  if (track.has_id() && is_starved(life)) {
    kalman_starve(track, life.kalman, tick.now, settings_.life.velocity_decay_s);
    if (!is_listed(track, life, settings_.life)) wait_where_seen(track, life);
  }
  if (life.starved_s == 0) remember_motion(track, life, tick);
  Contour& contour = tracks_.contour(slot);
  doubt_outline(contour, track, life.extent_px, tick.dt_s);
  kalman_update(track, life.kalman, contour.variance, settings_.kalman);
  track.mean_weight = mean_weight(track, contour, settings_.weight);

  const float extent2 = largest_variance(track);
  life.extent_px = std::sqrt(extent2);
  if (track.partners == 0) remember_extent(life, extent2, tick);
  if (track.has_id()) {
    const bool mature = life.age_s >= settings_.life.mature_s;
    shape_gate(track, settings_.gate, extent2, mature, is_starved(life) ? life.kalman.pxx : 0);
  }
  const bool doubtful = looks_double(track, contour, life, tick.noise_hz, settings_.gate);
  life.double_s = doubtful ? life.double_s + tick.dt_s : 0;
  const Sight s = sight_of(track, tick.now, 0, 0);
  coarse_.place(slot, s.mean_x, s.mean_y);
  return true;
}

void Engine::confirm(Slot slot) noexcept {
  Track& track = tracks_[slot];
  track.phase = Phase::kConfirmed;
  const Slot lost = lost_track_of(tracks_, slot, clock_.now(), settings_.life);
  if (lost != Tracks::kNone) {
    track.id = tracks_[lost].id;
    let_die(tracks_[lost], tracks_.life(lost));
  } else {
    track.id = next_id_++;
  }
  find_sibling(tracks_, slot, clock_.now(), settings_.pairs);
}

void Engine::remove(Slot slot) noexcept {
  coarse_.remove(slot);
  tracks_.remove(slot);
}

void Engine::tend_frame() noexcept {
  const std::uint64_t now_us = clock_.now_us();
  const std::uint64_t elapsed_us = now_us - frame_us_;
  frame_us_ = now_us;
  if (now_us - noise_us_ >= kNoisePeriod_us) measure_noise();
  pairs_.find(tracks_, clock_.now(), settings_.pairs);
  merge_pairs(seconds(elapsed_us));
  split_next();
  support_.scrub(clock_.now(), elapsed_us);
  owners_.scrub(clock_.now(), elapsed_us);
  orphans_.scrub(clock_.now(), elapsed_us);
}

void Engine::measure_noise() noexcept {
  noise_.update(seconds(clock_.now_us() - noise_us_));
  noise_us_ = clock_.now_us();
  const auto window_s = [&] { return 1e-6F * static_cast<float>(support_window_us_); };
  noise_hz_ = noise_.rate_hz();
  if (settings_.asks_support) noise_hz_ = noise_with_support(noise_hz_, window_s());
  // A neighbour is of use for as long as the counters of births remember it.
  const auto seed_us = static_cast<std::int32_t>(1e6F * settings_.seed_s);
  support_window_us_ = support_window_us(noise_hz_, settings_.support_window_us, seed_us);
  if (settings_.rejects) noise_hz_ = supported_noise(noise_hz_, window_s());
  settings_.update.far_trust = far_trust(noise_hz_);

  if (clock_.now_us() - started_us_ < static_cast<std::uint64_t>(settings_.warmup_us)) return;
  birth_threshold_ = settings_.birth_threshold(noise_hz_);
}

void Engine::merge_pairs(float dt_s) noexcept {
  for (const Slot slot : tracks_.active()) {
    forget_far_sibling(tracks_, slot, clock_.now(), settings_.pairs);
  }
  for (const Candidate& pair : pairs_.candidates()) {
    // Gone in a merge of this tick already, or grown by one.
    if (tracks_[pair.keeper].phase == Phase::kFree || tracks_[pair.other].phase == Phase::kFree)
      continue;
    if (!are_one(tracks_, pair, dt_s, settings_.merge)) continue;
    const Slot survivor = survivor_of(tracks_, pair.keeper, pair.other);
    const Slot other = survivor == pair.keeper ? pair.other : pair.keeper;
    merge(tracks_, survivor, other, clock_.now());
    remove(other);
    ++counters_.merges;
  }
}

// One track per tick, in turn.
void Engine::split_next() noexcept {
  const auto& active = tracks_.active();
  for (std::size_t tries = 0; tries < active.size(); ++tries) {
    next_split_ = next_split_ + 1 < active.size() ? next_split_ + 1 : 0;
    const Slot slot = active[next_split_];
    if (is_double(tracks_.life(slot))) return halve(slot);
    if (has_grown(tracks_[slot], tracks_.life(slot))) return split(slot);
  }
}

void Engine::split(Slot slot) noexcept {
  const Stamp now = clock_.now();
  const auto parts = parts_.find(owners_, tracks_, slot, now, settings_.link_us);
  const PartFinder::Part* home = home_of(parts, tracks_[slot], tracks_.life(slot), now);
  if (home == nullptr) return;
  float given = 0;
  for (const auto& part : parts) {
    if (part.distance(*home) < settings_.gate.birth_radius_px) continue;
    const float share = share_of(part, parts);
    if (begin_part(slot, part, share) != Tracks::kNone) given += share;
  }
  if (given == 0) return;
  keep_part(tracks_, slot, *home, 1 - given, settings_.cell_px, now);
  ++counters_.splits;
}

void Engine::halve(Slot slot) noexcept {
  const auto halves = halves_.find(owners_, tracks_, slot, clock_.now());
  if (!have_moved_apart(tracks_.life(slot), halves)) return;
  const float share = share_of(halves[1], halves);
  const Slot twin = begin_part(slot, halves[1], share);
  if (twin == Tracks::kNone) return;
  keep_part(tracks_, slot, halves[0], 1 - share, settings_.cell_px, clock_.now());
  raise_twin(tracks_, slot, twin, share, settings_.gate);
  tracks_[twin].id = next_id_++;
  ++counters_.splits;
}

Tracks::Slot Engine::begin_part(Slot parent, const PartFinder::Part& part, float share) noexcept {
  const Slot slot = begin_track(part.x, part.y);
  if (slot == Tracks::kNone) return slot;
  inherit_part(tracks_, parent, slot, part, share, settings_.cell_px);
  owners_.give(part.cells, slot, tracks_[slot].generation);
  return slot;
}

// ---- output ----

void Engine::read(std::int64_t t_us, std::vector<Cluster>& clusters) const {
  clusters.clear();
  EventClock clock = clock_;
  clock.advance_to(t_us);
  const std::uint64_t elapsed_us = clock.now_us() - clusters_us_;
  if (elapsed_us > kSilence_us) return;
  const Tick tick(clock.now(), seconds(elapsed_us), noise_hz_, settings_.life);
  foresee(tracks_, clock, tick, settings_, frame_, clusters);
}

}  // namespace asap::fast
