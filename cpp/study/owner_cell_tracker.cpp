#include "study/owner_cell_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "algorithms/fast/time.hpp"
#include "asap/core/check.hpp"
#include "study/mass_decay.hpp"

namespace asap {
namespace {

constexpr int kCell_px = 4;
constexpr std::uint64_t kTick_us = 1'000;
constexpr std::uint64_t kWarmUp_us = 30'000;
constexpr std::uint64_t kSplitPeriod_us = 20'000;
// Silence after which all clusters are deleted: stamps become ambiguous.
constexpr std::uint64_t kSilence_us = std::uint64_t{1} << 28;

constexpr std::int32_t kLink_us = 40'000;   // for which a cell remembers its owner
constexpr float kSeedDecay_s = 0.015F;      // of the counts of unassociated events
constexpr float kMassDecay_s = 0.03F;       // of the mass, the number of recent events
constexpr std::uint32_t kMeanEvents = 100;  // memory of the mean

constexpr float kConfirmEvents = 14;  // mass from which a cluster has an id
constexpr float kDeathEvents = 2;     // mass below which it is deleted
constexpr std::uint64_t kMinAge_us = 10'000;
constexpr std::uint64_t kMaxTentativeAge_us = 60'000;

constexpr float kMahalanobis2 = 9;  // elliptic gate
constexpr float kFarthest = 4;      // of the ellipse, in R

constexpr float kOutside = std::numeric_limits<float>::infinity();

// The cells of a split are connected over two cells of 4 px, the whole ones in half of such a
// radius.
const OwnerCellConfig& checked(const OwnerCellConfig& config) {
  require(16 <= config.radius_px && config.radius_px < 24, "radius_px", config.radius_px,
          "must be 16 to 23 px");
  return config;
}

// Of a frame in units of R / 32.
int in_coarse(int side_px, int radius_px) { return (32 * side_px + radius_px - 1) / radius_px; }

constexpr fast::KalmanRule kKalman{.acceleration = 2e5F,
                                   .per_speed3 = 0,
                                   .most = 2e5F,
                                   .contact = 2e5F,
                                   .measurement_scale = 6,
                                   .min_measurement_px2 = 0.2F,
                                   .mean_events = kMeanEvents};

// As of cells that are evenly filled.
void set_spread(fast::Track& track, std::size_t cells) noexcept {
  const auto pixels = static_cast<float>(cells * kCell_px * kCell_px);
  track.sxx = track.syy = std::max(4.0F, pixels / 10);
  track.sxy = 0;
}

void shape_ellipse(fast::Track& track) noexcept {
  const float sxx = track.sxx + 1;
  const float syy = track.syy + 1;
  const float det = std::max(1e-3F, sxx * syy - track.sxy * track.sxy);
  track.qa = syy / det;
  track.qb = -track.sxy / det;
  track.qc = sxx / det;
}

}  // namespace

OwnerCellTracker::OwnerCellTracker(const Config& config)
    : config_(checked(config)),
      frame_(config.width, config.height),
      radius2_(static_cast<float>(config.radius_px * config.radius_px)),
      coarse_scale_(32.0F / static_cast<float>(config.radius_px)),
      map_(config.width, config.height, kCell_px),
      owners_(map_),
      births_(map_, kSeedDecay_s),
      coarse_(in_coarse(config.width, config.radius_px), in_coarse(config.height, config.radius_px),
              kSlots),
      tracks_(kSlots),
      born_us_(kSlots),
      merge_(map_, kSlots, config.radius_px),
      parts_(map_),
      reciprocals_(kMeanEvents),
      kalman_(kKalman) {
  reset();
}

void OwnerCellTracker::reset() noexcept {
  clock_ = {};
  owners_.clear(clock_.now());
  births_.clear(clock_.now());
  coarse_.clear();
  tracks_.clear();
  kalman_ = kKalman;
  noise_ = {};
  next_id_ = 0;
  rejected_ = 0;
}

void OwnerCellTracker::set_keep(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  kalman_.mean_events = static_cast<std::uint32_t>(std::clamp(200 * gamma, 20.0, 100.0));
}

void OwnerCellTracker::process(EventSpan events) noexcept {
  for (const Event& event : events) process(event);
}

void OwnerCellTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  for (std::size_t i = 0; i < events.size(); ++i) labels[i] = process(events[i]);
}

std::int32_t OwnerCellTracker::process(const Event& event) noexcept {
  if (!frame_.contains(event)) [[unlikely]] {
    ++rejected_;
    return -1;
  }
  const bool first = !clock_.started();
  clock_.advance(event.t);
  if (first) [[unlikely]]
    start();
  if (clock_.now_us() - ticked_us_ >= kTick_us) [[unlikely]]
    tick();

  const std::size_t index = map_.cell(event.x, event.y);
  fast::OwnerGrid::Cell& cell = owners_[index];
  Slot slot = cell.slot;
  const bool valid = cell.generation == tracks_[slot].generation &&
                     fast::age_us(clock_.now(), cell.stamp) <= kLink_us;
  if (!valid || distance2(slot, event) == kOutside) {
    slot = nearest_around(event, index);
    if (slot == fast::Tracks::kNone) slot = try_birth(event, index);
    if (slot == fast::Tracks::kNone) return -1;
  }
  cell = {clock_.now(), tracks_[slot].generation, static_cast<std::uint8_t>(slot)};
  take(slot, event);
  return tracks_[slot].id;
}

// px^2 from the predicted mean, or kOutside.
float OwnerCellTracker::distance2(Slot slot, const Event& event) const noexcept {
  const fast::Track& track = tracks_[slot];
  const fast::Innovation s = fast::innovation_of(track, clock_.now(), static_cast<float>(event.x),
                                                 static_cast<float>(event.y));
  const float d2 = s.dx * s.dx + s.dy * s.dy;
  if (d2 <= radius2_) return d2;
  if (!track.has_id() || d2 > kFarthest * kFarthest * radius2_) return kOutside;
  const float ellipse =
      s.dx * s.dx * track.qa + 2 * s.dx * s.dy * track.qb + s.dy * s.dy * track.qc;
  return ellipse <= kMahalanobis2 ? d2 : kOutside;
}

OwnerCellTracker::Slot OwnerCellTracker::nearest_around(const Event& event,
                                                        std::size_t cell) noexcept {
  Slot best = fast::Tracks::kNone;
  float least = kOutside;
  const auto consider = [&](Slot slot) {
    const float d2 = distance2(slot, event);
    if (d2 >= least) return;
    least = d2;
    best = slot;
  };
  // Half a pixel on: rounding must not move an event into the cell before its own.
  const auto along = [&](std::uint16_t pixel) {
    return static_cast<std::size_t>(coarse(static_cast<float>(pixel) + 0.5F));
  };
  coarse_.for_each_around(along(event.x), along(event.y), consider);
  if (best != fast::Tracks::kNone) return best;
  map_.for_each_neighbour(cell, [&](std::size_t neighbour) {
    const fast::OwnerGrid::Cell& owner = owners_[neighbour];
    if (owner.generation != tracks_[owner.slot].generation) return;
    if (fast::age_us(clock_.now(), owner.stamp) <= kLink_us) consider(owner.slot);
  });
  return best;
}

OwnerCellTracker::Slot OwnerCellTracker::try_birth(const Event& event, std::size_t cell) noexcept {
  noise_.count();
  const float sum = births_.count(cell, clock_.now());
  if (sum < noise_.threshold()) return fast::Tracks::kNone;
  const Slot slot = begin_track(static_cast<float>(event.x), static_cast<float>(event.y));
  if (slot == fast::Tracks::kNone) return slot;
  tracks_.state(slot).mass = std::min(sum, 0.6F * kConfirmEvents);
  births_.forget(cell);
  return slot;
}

OwnerCellTracker::Slot OwnerCellTracker::begin_track(float x, float y) noexcept {
  const Slot slot = tracks_.create(x, y, clock_.now());
  if (slot == fast::Tracks::kNone) return slot;
  born_us_[slot] = clock_.now_us();
  merge_.forget(slot);
  coarse_.place(slot, coarse(x), coarse(y));
  return slot;
}

void OwnerCellTracker::take(Slot slot, const Event& event) noexcept {
  fast::Track& track = tracks_[slot];
  const fast::Stamp now = clock_.now();
  const fast::Innovation s =
      fast::innovation_of(track, now, static_cast<float>(event.x), static_cast<float>(event.y));
  const float a = reciprocals_[std::min(++track.events, kalman_.mean_events)];
  float& mass = tracks_.state(slot).mass;
  const auto age_us = static_cast<float>(fast::age_us(now, track.stamp));
  mass = mass * mass_decay(age_us * (1e-6F / kMassDecay_s)) + 1;
  track.x = s.mean_x + a * s.dx;
  track.y = s.mean_y + a * s.dy;
  track.sxx = (1 - a) * (track.sxx + a * s.dx * s.dx);
  track.sxy = (1 - a) * (track.sxy + a * s.dx * s.dy);
  track.syy = (1 - a) * (track.syy + a * s.dy * s.dy);
  track.stamp = now;
}

// ---- per tick ----

void OwnerCellTracker::start() noexcept { started_us_ = ticked_us_ = split_us_ = clock_.now_us(); }

void OwnerCellTracker::tick() noexcept {
  const std::uint64_t now_us = clock_.now_us();
  const std::uint64_t elapsed_us = now_us - ticked_us_;
  ticked_us_ = now_us;
  measure_noise(1e-6F * static_cast<float>(elapsed_us));
  const auto& active = tracks_.active();
  for (std::size_t i = 0; i < active.size();) {
    const Slot slot = active[i];
    if (elapsed_us <= kSilence_us && tend(slot)) {
      ++i;
    } else {
      remove(slot);
    }
  }
  merge_all();
  if (now_us - split_us_ >= kSplitPeriod_us) {
    split_us_ = now_us;
    const std::size_t before = active.size();
    for (std::size_t i = 0; i < before; ++i) split(active[i]);
  }
  owners_.scrub(clock_.now(), elapsed_us);
  births_.scrub(clock_.now(), elapsed_us);
}

void OwnerCellTracker::measure_noise(float elapsed_s) noexcept {
  const auto area = static_cast<float>(frame_.width() * frame_.height());
  const auto taken = static_cast<float>(tracks_.active().size()) * std::numbers::pi_v<float>;
  const float free = std::max(0.2F * area, area - taken * radius2_);
  const bool warming = clock_.now_us() - started_us_ < kWarmUp_us;
  constexpr float kAround_px = 3 * kCell_px;
  noise_.update(elapsed_s, free, warming, kAround_px * kAround_px, kSeedDecay_s);
}

void OwnerCellTracker::merge_all() noexcept {
  for (Slot gone; (gone = merge_.join_tentative(tracks_, owners_)) != fast::Tracks::kNone;) {
    remove(gone);
  }
  merge_.hold(tracks_);
  for (Slot gone; (gone = merge_.join_confirmed(tracks_, owners_)) != fast::Tracks::kNone;) {
    remove(gone);
  }
}

// False: the cluster is to be deleted.
bool OwnerCellTracker::tend(Slot slot) noexcept {
  fast::Track& track = tracks_[slot];
  fast::TrackState& state = tracks_.state(slot);
  const auto since_s = 1e-6F * static_cast<float>(fast::age_us(clock_.now(), track.stamp));
  const float mass = state.mass * fast::decay(since_s / kMassDecay_s);
  const float circle_px2 = std::numbers::pi_v<float> * radius2_;
  const float det = std::max(0.0F, track.sxx * track.syy - track.sxy * track.sxy);
  const float ellipse_px2 = kMahalanobis2 * std::numbers::pi_v<float> * std::sqrt(det);
  const float noise = noise_.rate_hz() * std::max(circle_px2, ellipse_px2) * kMassDecay_s;
  const std::uint64_t age_us = clock_.now_us() - born_us_[slot];
  if (mass < kDeathEvents + noise + 2 * std::sqrt(noise) && age_us > kMinAge_us) return false;
  if (!track.has_id() && age_us > kMaxTentativeAge_us) return false;
  if (fast::has_left(track, clock_.now(), {frame_.width(), frame_.height()})) return false;

  const float birth_noise = noise_.rate_hz() * circle_px2 * kMassDecay_s;
  if (!track.has_id() && mass >= kConfirmEvents + birth_noise + 3 * std::sqrt(birth_noise)) {
    track.phase = fast::Phase::kConfirmed;
    track.id = next_id_++;
    state.kalman = {.x = track.x, .y = track.y, .stamp = track.stamp, .events = track.events};
  }
  if (track.has_id()) {
    fast::kalman_update(track, state.kalman, 0, kalman_);
    shape_ellipse(track);
  }
  coarse_.place(slot, coarse(track.x), coarse(track.y));
  return true;
}

void OwnerCellTracker::remove(Slot slot) noexcept {
  coarse_.remove(slot);
  tracks_.remove(slot);
}

void OwnerCellTracker::split(Slot slot) noexcept {
  constexpr std::size_t kMinCells = 5;
  constexpr std::uint32_t kEvents = 10;
  fast::Track& track = tracks_[slot];
  fast::TrackState& state = tracks_.state(slot);
  const float variance = std::max(track.sxx, track.syy);
  if (!track.has_id() || 4 * variance < radius2_) return;
  state.extent_px = 1.2F * std::sqrt(variance);  // the finder looks 2.5 extents and 6 px around
  std::array<fast::Part, fast::PartFinder::kMaxParts> kept{};
  std::size_t count = 0;
  for (const auto& part : parts_.find(owners_, tracks_, slot, clock_.now(), kLink_us)) {
    if (part.cells.size() >= kMinCells) kept[count++] = part;
  }
  const std::span<const fast::Part> parts(kept.data(), count);
  const auto* kept_part = fast::part_at_prediction(parts, track, state, clock_.now());
  if (kept_part == nullptr) return;
  const auto is_far = [&](const auto& a, const auto& b) {
    const float distance = a.distance(b);
    return distance * distance >= radius2_;
  };
  const bool apart = std::any_of(parts.begin(), parts.end(), [&](const auto& a) {
    return std::any_of(parts.begin(), parts.end(), [&](const auto& b) { return is_far(a, b); });
  });
  if (!apart) return;
  for (const auto& part : parts) {
    if (!is_far(part, *kept_part)) continue;
    const Slot child = begin_track(part.x, part.y);
    if (child == fast::Tracks::kNone) continue;
    tracks_.state(child).mass = 0.4F * state.mass;
    tracks_[child].events = kEvents;
    set_spread(tracks_[child], part.cells.size());
  }
  track.x = kept_part->x;
  track.y = kept_part->y;
  set_spread(track, kept_part->cells.size());
}

// ---- output ----

std::vector<Cluster> OwnerCellTracker::clusters_at(std::int64_t t_us) const {
  fast::EventClock clock = clock_;
  clock.advance_to(t_us);
  std::vector<Cluster> clusters;
  for (const Slot slot : tracks_.active()) {
    const fast::Track& track = tracks_[slot];
    if (!track.has_id()) continue;
    const fast::Point mean = fast::predicted_mean(track, clock.now());
    clusters.push_back({.id = track.id,
                        .x = mean.x,
                        .y = mean.y,
                        .vx = track.vx,
                        .vy = track.vy,
                        .cxx = track.sxx,
                        .cxy = track.sxy,
                        .cyy = track.syy,
                        .size = std::lround(tracks_.state(slot).mass),
                        .t_last = clock_.stamp_us(fast::age_us(clock_.now(), track.stamp))});
  }
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  return clusters;
}

}  // namespace asap
