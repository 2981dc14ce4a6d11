#include "study/jaer_cluster_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"
#include "core/check.hpp"

namespace asap {
namespace {

constexpr float kMixing = 0.05F;  // of an event's position into the box's
constexpr float kMassDecay_us = 10'000;
constexpr std::uint64_t kJaerTick_us = 1'000;
constexpr std::uint64_t kGrace_us = 10'000;  // for which a box may be weak
constexpr float kVelocityMemory_s = 0.02F;
constexpr float kMergeDistance_px = 16;
constexpr float kAlike = 0.5F;  // cosine of 60 degrees

// exp(-u), u >= 0; for short times, which are usual, the first terms of its series: error below
// .004.
constexpr float mass_decay(float u) noexcept {
  return u < 0.25F ? 1 - u + u * u / 2 : fast::decay(u);
}

}  // namespace

JaerClusterTracker::JaerClusterTracker(const Config& config)
    : config_(config),
      frame_(config.width, config.height),
      boxes_(kBoxes),
      index_(config.width, config.height, kBoxes) {
  active_.reserve(kBoxes);
  free_.reserve(kBoxes);
  reset();
}

void JaerClusterTracker::reset() noexcept {
  clock_ = {};
  active_.clear();
  free_.clear();
  for (std::size_t slot = kBoxes; slot-- > 0;) free_.push_back(static_cast<Slot>(slot));
  index_.clear();
  ticked_us_ = clock_.now_us();
  next_id_ = 0;
  rejected_ = 0;
}

// ---- per event ----

void JaerClusterTracker::process(EventSpan events) noexcept {
  for (const Event& event : events) process(event);
}

void JaerClusterTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  for (std::size_t i = 0; i < events.size(); ++i) labels[i] = process(events[i]);
}

std::int32_t JaerClusterTracker::process(const Event& event) noexcept {
  if (!frame_.contains(event)) [[unlikely]] {
    ++rejected_;
    return -1;
  }
  clock_.advance(event.t);
  if (clock_.now_us() - ticked_us_ >= kJaerTick_us) [[unlikely]]
    tick();
  Slot slot = nearest_around(event);
  if (slot == fast::CoarseIndex::kNone) {
    slot = create(static_cast<float>(event.x), static_cast<float>(event.y));
    if (slot == fast::CoarseIndex::kNone) return -1;
  } else {
    take(slot, event);
  }
  const Box& box = boxes_[slot];
  return box.mass > kVisibleMass ? box.id : -1;
}

// By the L1 distance, among the boxes that hold the event.
JaerClusterTracker::Slot JaerClusterTracker::nearest_around(const Event& event) const noexcept {
  const auto x = static_cast<float>(event.x);
  const auto y = static_cast<float>(event.y);
  Slot best = fast::CoarseIndex::kNone;
  float least = 2 * kHalfSide_px;
  index_.for_each_around(event.x, event.y, [&](Slot slot) {
    const float dx = std::abs(x - boxes_[slot].x);
    const float dy = std::abs(y - boxes_[slot].y);
    if (dx >= kHalfSide_px || dy >= kHalfSide_px || dx + dy >= least) return;
    least = dx + dy;
    best = slot;
  });
  return best;
}

JaerClusterTracker::Slot JaerClusterTracker::create(float x, float y) noexcept {
  if (free_.empty()) return fast::CoarseIndex::kNone;
  const Slot slot = free_.back();
  free_.pop_back();
  active_.push_back(slot);
  const std::uint64_t now_us = clock_.now_us();
  boxes_[slot] = {.x = x,
                  .y = y,
                  .mass = 1,
                  .last_us = now_us,
                  .since_us = now_us,
                  .vx = 0,
                  .vy = 0,
                  .ticked_x = x,
                  .ticked_y = y,
                  .id = next_id_++};
  index_.place(slot, x, y);
  return slot;
}

void JaerClusterTracker::take(Slot slot, const Event& event) noexcept {
  Box& box = boxes_[slot];
  box.x += kMixing * (static_cast<float>(event.x) - box.x);
  box.y += kMixing * (static_cast<float>(event.y) - box.y);
  box.mass = 1 + mass_now(box);
  box.last_us = clock_.now_us();
  index_.place(slot, box.x, box.y);
}

float JaerClusterTracker::mass_now(const Box& box) const noexcept {
  return box.mass * mass_decay(static_cast<float>(clock_.now_us() - box.last_us) / kMassDecay_us);
}

// ---- per tick ----

// A box is a mean of pixels, so it never leaves the frame.
void JaerClusterTracker::tick() noexcept {
  const std::uint64_t now_us = clock_.now_us();
  const float dt_s = 1e-6F * static_cast<float>(now_us - ticked_us_);
  ticked_us_ = now_us;
  for (std::size_t i = 0; i < active_.size();) {
    Box& box = boxes_[active_[i]];
    if (now_us - box.since_us > kGrace_us && mass_now(box) < kVisibleMass) {
      remove(i);
    } else {
      follow(box, dt_s);
      ++i;
    }
  }
  merge_all();
}

void JaerClusterTracker::follow(Box& box, float dt_s) const noexcept {
  const float weight = 1 - fast::decay(dt_s / kVelocityMemory_s);
  box.vx += weight * ((box.x - box.ticked_x) / dt_s - box.vx);
  box.vy += weight * ((box.y - box.ticked_y) / dt_s - box.vy);
  box.ticked_x = box.x;
  box.ticked_y = box.y;
}

bool JaerClusterTracker::are_one(const Box& a, const Box& b) const noexcept {
  if (fast::length(a.x - b.x, a.y - b.y) >= kMergeDistance_px) return false;
  const float speeds = fast::length(a.vx, a.vy) * fast::length(b.vx, b.vy);
  const bool compared = mass_now(a) > kVisibleMass && mass_now(b) > kVisibleMass && speeds > 0;
  return !compared || a.vx * b.vx + a.vy * b.vy > kAlike * speeds;
}

void JaerClusterTracker::merge_all() noexcept {
  for (std::size_t i = 0; i < active_.size(); ++i) {
    for (std::size_t j = i + 1; j < active_.size();) {
      Box& a = boxes_[active_[i]];
      Box& b = boxes_[active_[j]];
      if (!are_one(a, b)) {
        ++j;
        continue;
      }
      const float mass = mass_now(a) + mass_now(b);
      const bool first = mass_now(a) >= mass_now(b);
      Box& survivor = first ? a : b;
      survivor.mass = mass;
      survivor.last_us = clock_.now_us();
      survivor.since_us = std::min(a.since_us, b.since_us);
      remove(first ? j : i);
      if (!first) j = i + 1;  // another box stands at i now
    }
  }
}

void JaerClusterTracker::remove(std::size_t index) noexcept {
  const Slot slot = active_[index];
  index_.remove(slot);
  free_.push_back(slot);
  active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(index));
}

// ---- output ----

std::vector<Cluster> JaerClusterTracker::clusters_at(std::int64_t t_us) const {
  EventClock clock = clock_;
  clock.advance_to(t_us);
  constexpr double kVariance_px2 = kHalfSide_px * kHalfSide_px / 3;  // a box full of events
  std::vector<Cluster> clusters;
  for (const Slot slot : active_) {
    const Box& box = boxes_[slot];
    const auto age_us = static_cast<float>(clock.now_us() - box.last_us);
    const float mass = box.mass * mass_decay(age_us / kMassDecay_us);
    if (mass <= kVisibleMass) continue;
    clusters.push_back(
        {.id = box.id,
         .x = box.x + 1e-6F * age_us * box.vx,
         .y = box.y + 1e-6F * age_us * box.vy,
         .vx = box.vx,
         .vy = box.vy,
         .cxx = kVariance_px2,
         .cxy = 0,
         .cyy = kVariance_px2,
         .size = std::lround(mass),
         .t_last = clock_.latest_us() - static_cast<std::int64_t>(clock_.now_us() - box.last_us)});
  }
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  return clusters;
}

}  // namespace asap
