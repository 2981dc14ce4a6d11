#include "algorithms/fast/objects.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "algorithms/fast/pairs.hpp"

namespace asap::inline v0_1::fast {
namespace {

float seconds_between(std::uint64_t before_us, std::uint64_t after_us) noexcept {
  return 1e-6F * static_cast<float>(after_us - before_us);
}

float mass_of(const TrackState& state) noexcept { return 1 + state.mass; }

// Whether two tracks lie as close together as parts of one object.
bool touch(const Track& a, const Track& b, Stamp now) noexcept {
  constexpr float kReach = 2.5F;  // standard deviations along the line of centres ...
  constexpr float kReach_px = 8;  // ... and px
  const Point from = predicted_mean(a, now);
  const Point to = predicted_mean(b, now);
  const float dx = to.x - from.x;
  const float dy = to.y - from.y;
  const float variances = std::max(2.0F, a.sxx + a.syy) + std::max(2.0F, b.sxx + b.syy);
  if (dx * dx + dy * dy > 4 * kReach * kReach * variances + 2 * kReach_px * kReach_px) return false;
  const float distance = length(dx, dy);
  const float ux = distance > 0 ? dx / distance : 1;
  const float uy = distance > 0 ? dy / distance : 0;
  return distance <= kReach * (spread_along(a, ux, uy) + spread_along(b, ux, uy)) + kReach_px;
}

// The edges of pixels, and of a thing of which few events lie beyond the sides.
Box box_of(const Contour& contour, const Point& mean) noexcept {
  constexpr float kBeyond_px = 1;
  const Box box = contour.sides.moved(mean.x, mean.y);
  return {box.left - kBeyond_px, box.top - kBeyond_px, box.right + kBeyond_px,
          box.bottom + kBeyond_px};
}

}  // namespace

// ---- sums --------------------------------------------------------------------------------------

void ObjectSum::add(Tracks::Slot slot, const Track& track, const TrackState& state,
                    const Contour& contour, Stamp now) noexcept {
  const Point mean = predicted_mean(track, now);
  const Box own = box_of(contour, mean);
  box = parts++ == 0 ? own : united(box, own);
  mass += state.mass;
  rate_hz += state.slow_rate_hz;
  const Stamp newest = track.events != state.events ? track.stamp : state.last_event;
  quiet_us = std::min(quiet_us, age_us(now, newest));
  if (lead != Tracks::kNone && mass_of(state) <= lead_mass) return;
  lead = slot;
  lead_mass = mass_of(state);
  x = mean.x;
  y = mean.y;
  vx = track.vx;
  vy = track.vy;
}

bool ObjectSum::is_quiet() const noexcept {
  constexpr float kShortest_us = 20'000;
  constexpr float kEvents = 5;  // as many are missing at the object's own rate
  return static_cast<float>(quiet_us) >
         std::max(kShortest_us, 1e6F * kEvents / std::max(1.0F, rate_hz));
}

// ---- objects -----------------------------------------------------------------------------------

Objects::Objects(std::size_t slots) : parts_(slots) {
  objects_.reserve(2 * slots);
  listed_.reserve(slots);
  component_.reserve(slots);
}

void Objects::clear() noexcept {
  std::fill(parts_.begin(), parts_.end(), Part{});
  objects_.clear();
  now_us_ = 0;
  begun_ = 0;
}

std::size_t Objects::object_of(Slot slot, const Track& track) const noexcept {
  if (parts_[slot].generation != track.generation) return kNone;
  std::size_t object = parts_[slot].object;
  while (object != kNone && objects_[object].bond.joined) object = objects_[object].bond.other;
  return object;
}

void Objects::update(const Tracks& tracks, const NoiseTiles& noise, std::uint64_t now_us,
                     std::int32_t& next_id) noexcept {
  next_id_ = &next_id;
  const float dt_s = seconds_between(now_us_, now_us);
  now_us_ = now_us;
  forget_old();
  list(tracks);
  add_up(tracks);
  place_new(tracks);
  adopt(tracks);
  leave(tracks, dt_s);
  join(tracks, dt_s);
  judge(tracks, noise);
  note_ways(tracks);
}

// ---- which track is a part of which object ----

void Objects::list(const Tracks& tracks) noexcept {
  listed_.clear();
  for (const Slot slot : tracks.active()) {
    if (!is_listed(tracks[slot], tracks.state(slot))) continue;
    listed_.push_back(slot);
    if (parts_[slot].generation == tracks[slot].generation) continue;
    parts_[slot] = {.generation = tracks[slot].generation};
  }
}

// An object that has lost its parts keeps the last sum.
void Objects::add_up(const Tracks& tracks) noexcept {
  constexpr std::uint64_t kGap_us = 15'000;
  const Stamp now = static_cast<Stamp>(now_us_);
  for (Object& object : objects_) object.sum.parts = 0;
  for (const Slot slot : listed_) {
    if (parts_[slot].object == kNone) continue;
    Object& object = objects_[parts_[slot].object];
    if (object.sum.parts == 0) object.sum = {};
    if (now_us_ - object.seen_us > kGap_us) object.back_us = now_us_;
    object.sum.add(slot, tracks[slot], tracks.state(slot), tracks.contour(slot), now);
    object.seen_us = now_us_;
  }
}

void Objects::place_new(const Tracks& tracks) noexcept {
  bool any = false;
  for (const Slot slot : listed_) {
    if (parts_[slot].object != kNone) continue;
    const std::size_t lost = find_lost(predicted_mean(tracks[slot], static_cast<Stamp>(now_us_)));
    const std::size_t object = lost != kNone ? lost : begin(id_of(std::span(&slot, 1), tracks));
    parts_[slot].object = object;
    objects_[object].sum.parts = 1;  // it is lost no longer
    objects_[object].seen_us = now_us_;
    any = true;
  }
  if (any) add_up(tracks);
}

// Its own track finds it where it was lost. That may be its rear alone, while it has moved on.
bool Objects::is_just_back(const Object& object) const noexcept {
  constexpr std::uint64_t kBack_us = 60'000;
  return object.back_us > 0 && now_us_ - object.back_us < kBack_us;
}

void Objects::note_ways(const Tracks& tracks) noexcept {
  for (Object& object : objects_) {
    const ObjectSum& sum = object.sum;
    if (object.id < 0 || sum.parts == 0 || tracks.state(sum.lead).starved_s > 0) continue;
    if (is_just_back(object)) continue;
    const TrackState& state = tracks.state(sum.lead);
    object.way = {now_us_,
                  {sum.x, sum.y},
                  {state.average_vx, state.average_vy},
                  {sum.box.width() / 2, sum.box.height() / 2}};
  }
}

// LOST: the object that must have reappeared at this place, where it has moved on to, behind
// another: one without parts, or just back.
std::size_t Objects::find_lost(const Point& place) const noexcept {
  constexpr float kTolerance_px = 12;
  constexpr float kPerTravel = 0.35F;  // the velocity is not exact
  std::size_t best = kNone;
  float least = 1;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i].id < 0 || (objects_[i].sum.parts > 0 && !is_just_back(objects_[i]))) continue;
    const Way& way = objects_[i].way;
    const float unseen_s = seconds_between(way.at_us, now_us_);
    const float travel_x = way.velocity.x * unseen_s;
    const float travel_y = way.velocity.y * unseen_s;
    const float dx = std::abs(place.x - way.place.x - travel_x) - way.half.x;
    const float dy = std::abs(place.y - way.place.y - travel_y) - way.half.y;
    const float tolerance = kTolerance_px + kPerTravel * length(travel_x, travel_y);
    const float distance = length(std::max(0.0F, dx), std::max(0.0F, dy)) / tolerance;
    if (distance >= least) continue;
    least = distance;
    best = i;
  }
  return best;
}

// The id of the first of these tracks that has founded no object.
std::int64_t Objects::id_of(std::span<const Slot> founders, const Tracks& tracks) noexcept {
  for (const Slot slot : founders) {
    if (!std::exchange(parts_[slot].has_founded, true)) return tracks[slot].id;
  }
  return (*next_id_)++;
}

std::size_t Objects::begin(std::int64_t id) noexcept {
  const bool is_full = objects_.size() == 2 * parts_.size();
  std::size_t chosen = kNone;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i].id < 0) {
      chosen = i;
      break;
    }
    if (!is_full || objects_[i].sum.parts > 0) continue;
    if (chosen == kNone || objects_[i].seen_us < objects_[chosen].seen_us) chosen = i;
  }
  if (chosen == kNone) {
    chosen = objects_.size();
    objects_.emplace_back();
  }
  forget(chosen);
  objects_[chosen] = {.id = id, .order = begun_++, .born_us = now_us_, .seen_us = now_us_};
  return chosen;
}

void Objects::forget(std::size_t object) noexcept {
  objects_[object].id = -1;
  for (Object& one : objects_) {
    if (one.bond.other == object) one.bond = {};
  }
  for (Part& part : parts_) {
    if (part.object == object) part.object = kNone;
  }
}

void Objects::forget_old() noexcept {
  constexpr std::uint64_t kRemembered_us = 500'000;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i].id >= 0 && now_us_ - objects_[i].seen_us > kRemembered_us) forget(i);
  }
}

// ADOPT: what begins at a large object is a piece of it.
void Objects::adopt(const Tracks& tracks) noexcept {
  constexpr std::uint64_t kYoung_us = 50'000;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    Object& child = objects_[i];
    if (child.id < 0 || child.sum.parts == 0 || child.has_left) continue;
    if (now_us_ - child.born_us >= kYoung_us) continue;
    const std::size_t parent = find_parent(tracks, i);
    if (parent == kNone) continue;
    for (const Slot slot : listed_) {
      if (parts_[slot].object == i) parts_[slot].move_to(parent);
    }
    forget(i);
    add_up(tracks);
  }
}

// The first object that one of the object's tracks touches, of those that are wanted.
template <class Wanted>
std::size_t Objects::find_touched(const Tracks& tracks, std::size_t object,
                                  Wanted wanted) const noexcept {
  const Stamp now = static_cast<Stamp>(now_us_);
  for (const Slot slot : listed_) {
    if (parts_[slot].object != object) continue;
    for (const Slot other : listed_) {
      const std::size_t whole = parts_[other].object;
      if (wanted(whole) && touch(tracks[slot], tracks[other], now)) return whole;
    }
  }
  return kNone;
}

std::size_t Objects::find_parent(const Tracks& tracks, std::size_t child) const noexcept {
  return find_touched(tracks, child, [&](std::size_t object) {
    return object != child && may_adopt(objects_[object]);
  });
}

bool Objects::may_adopt(const Object& object) const noexcept {
  constexpr std::uint64_t kOld_us = 100'000;
  constexpr float kWide_px = 36;
  return std::max(object.sum.box.width(), object.sum.box.height()) >= kWide_px &&
         now_us_ - object.born_us > kOld_us;
}

// LEAVE: parts that have been apart from the others for long are an object of their own.
void Objects::leave(const Tracks& tracks, float dt_s) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i].id >= 0 && objects_[i].sum.parts > 1) any = divide(tracks, i, dt_s) || any;
  }
  if (any) add_up(tracks);
}

bool Objects::divide(const Tracks& tracks, std::size_t object, float dt_s) noexcept {
  constexpr float kApart_s = 0.06F;
  component_.clear();
  for (const Slot slot : listed_) {
    if (parts_[slot].object == object) component_.push_back(slot);
  }
  const std::size_t main = heaviest_component(tracks);
  bool any = false;
  for (std::size_t first = 0, end = 0; first < component_.size(); first = end) {
    end = grow_component(tracks, first);
    const std::span component = std::span(component_).subspan(first, end - first);
    bool leaves = first != main;
    for (const Slot slot : component) {
      parts_[slot].apart_s = first == main ? 0 : parts_[slot].apart_s + dt_s;
      leaves = leaves && parts_[slot].apart_s >= kApart_s;
    }
    if (!leaves) continue;
    const std::size_t own = begin(id_of(component, tracks));
    objects_[own].has_left = any = true;
    for (const Slot slot : component) parts_[slot].move_to(own);
  }
  return any;
}

// Where it begins in component_.
std::size_t Objects::heaviest_component(const Tracks& tracks) noexcept {
  std::size_t heaviest = 0;
  float most = 0;
  for (std::size_t first = 0, end = 0; first < component_.size(); first = end) {
    end = grow_component(tracks, first);
    float mass = 0;
    for (std::size_t k = first; k < end; ++k) mass += mass_of(tracks.state(component_[k]));
    if (mass <= most) continue;
    most = mass;
    heaviest = first;
  }
  return heaviest;
}

// Puts the parts that hang together with the first one behind it, and returns their end.
std::size_t Objects::grow_component(const Tracks& tracks, std::size_t first) noexcept {
  const auto now = static_cast<Stamp>(now_us_);
  std::size_t end = first + 1;
  for (std::size_t next = first; next < end; ++next) {
    for (std::size_t k = end; k < component_.size(); ++k) {
      if (!touch(tracks[component_[next]], tracks[component_[k]], now)) continue;
      std::swap(component_[end++], component_[k]);
    }
  }
  return end;
}

// ---- which objects are one ----

// JOIN: two objects that touch and begin together are one thing, which is too large or too sparse
// for one gate, until the box around both changes: what appears or starts to move fires at all its
// edges. So are two that show one edge each, of opposite polarity, the two sides of a thing: an
// object of its own has both. All keep their ids for when they part.
void Objects::join(const Tracks& tracks, float dt_s) noexcept {
  constexpr float kEdges_s = 0.01F;
  constexpr float kApart_s = 0.06F;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    Object& object = objects_[i];
    Bond& bond = object.bond;
    if (object.id < 0 || object.sum.parts == 0) continue;
    if (bond.other == kNone) {
      find_bond(tracks, i);
      bond.joined = bond.other != kNone && began_together(object, objects_[bond.other]);
    } else if (keeps_bond(object)) {
      bond.apart_s = 0;
      if (have_opposite_edges(tracks, object.sum.lead, objects_[bond.other].sum.lead)) {
        bond.edges_s += dt_s;
      }
      bond.joined = bond.joined || bond.edges_s >= kEdges_s;
    } else {
      bond.apart_s += dt_s;
      if (bond.joined && bond.apart_s < kApart_s) continue;
      object.has_left = object.has_left || bond.joined;
      bond = {};
    }
  }
}

bool Objects::began_together(const Object& younger, const Object& older) const noexcept {
  constexpr std::uint64_t kTogether_us = 30'000;
  return now_us_ - younger.born_us < kTogether_us && younger.born_us - older.born_us < kTogether_us;
}

// With the heaviest of the older objects that it touches, else with one that it faces.
void Objects::find_bond(const Tracks& tracks, std::size_t object) noexcept {
  Object& younger = objects_[object];
  std::size_t best = kNone;
  const auto is_better = [&](std::size_t whole) {
    return objects_[whole].order < younger.order &&
           (best == kNone || objects_[whole].sum.mass > objects_[best].sum.mass);
  };
  std::size_t next = kNone;
  while ((next = find_touched(tracks, object, is_better)) != kNone) best = next;
  for (std::size_t i = 0; best == kNone && i < objects_.size(); ++i) {
    const Object& older = objects_[i];
    if (older.id < 0 || older.sum.parts == 0 || older.order >= younger.order) continue;
    if (face(tracks, younger, older)) best = i;
  }
  if (best == kNone) return;
  const Box box = united(younger.sum.box, objects_[best].sum.box);
  younger.bond = {.other = best, .width = box.width(), .height = box.height()};
}

// Whether they lie as the front and the rear of a thing that moves along itself, whose long sides
// do not fire: opposite edges, both across the line between them.
bool Objects::face(const Tracks& tracks, const Object& one, const Object& other) const noexcept {
  constexpr float kReach = 10;  // standard deviations of both
  constexpr float kThin = 2;    // ratio of standard deviations
  if (!have_opposite_edges(tracks, one.sum.lead, other.sum.lead)) return false;
  const float distance = length(other.sum.x - one.sum.x, other.sum.y - one.sum.y);
  const float ux = (other.sum.x - one.sum.x) / distance;
  const float uy = (other.sum.y - one.sum.y) / distance;
  float across = 0;
  for (const Slot slot : {one.sum.lead, other.sum.lead}) {
    const float own = spread_along(tracks[slot], -uy, ux);
    if (!(own > kThin * spread_along(tracks[slot], ux, uy))) return false;
    across += own;
  }
  return distance < kReach * across;
}

// Whether the box around both is as it was: one grows and the other shrinks where events go from
// the one to the other.
bool Objects::keeps_bond(const Object& object) const noexcept {
  constexpr float kTolerance_px = 4;
  constexpr float kPerSide = 0.05F;
  const Bond& bond = object.bond;
  const ObjectSum& other = objects_[bond.other].sum;
  if (other.parts == 0) return false;
  const Box box = united(object.sum.box, other.box);
  return std::max(std::abs(box.width() - bond.width), std::abs(box.height() - bond.height)) <=
         kTolerance_px + kPerSide * std::max(bond.width, bond.height);
}

// ---- which object is noise ----

// NOISE: events with support against those without in the same place, above the rate of noise
// elsewhere. Noise has one polarity, a moving object has two edges. A lamp is no object.
void Objects::judge(const Tracks& tracks, const NoiseTiles& noise) noexcept {
  constexpr float kMinRatio = 2;    // hidden below; shown from here on with both polarities ...
  constexpr float kSureRatio = 12;  // ... and from here on in any case
  for (Object& object : objects_) object.lone_hz = 0;
  for (const Slot slot : listed_) {
    const Point mean = predicted_mean(tracks[slot], static_cast<Stamp>(now_us_));
    const float excess_hz = std::max(0.0F, noise.rate_near_hz(mean.x, mean.y) - noise.rate_hz());
    objects_[parts_[slot].object].lone_hz += excess_hz * mature_gate_area(tracks[slot]);
  }
  for (Object& object : objects_) {
    if (object.id < 0 || object.sum.parts == 0) continue;
    const float ratio = object.sum.rate_hz / std::max(1e-3F, object.lone_hz);
    const bool is_sure = ratio >= kSureRatio;
    const bool is_weak = ratio < kMinRatio && !has_edges_apart(tracks, object.sum.lead);
    if (is_weak || tracks.contour(object.sum.lead).flickers(object.is_noise)) {
      object.is_noise = true;
    } else if (is_sure || has_both_edges(tracks, object.sum.lead)) {
      object.is_noise = false;
    }
  }
}

}  // namespace asap::inline v0_1::fast
