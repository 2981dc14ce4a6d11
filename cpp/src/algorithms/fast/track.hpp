// Track: one cluster of the fast engine, and Tracks: the table of them. What every event touches
// stands in the 64 bytes of Track, the contour beside it, what only the tick touches in Life. A
// slot that is given back changes its generation, so whoever noted the old one knows. One thread.
// O(1) but for for_each; allocates in the constructor only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/contour.hpp"
#include "algorithms/fast/stamp.hpp"

namespace asap::fast {

inline constexpr std::size_t kMaxPartners = 3;

enum class Phase : std::uint8_t {
  kFree,
  kTentative,  // may be noise: no id, not listed
  kConfirmed,
  kCoasting,  // confirmed once, too few events now: keeps id and gate for a while
};

struct alignas(64) Track {
  float x = 0;  // px, mean of the events at `stamp`
  float y = 0;
  float vx = 0;  // px/s, of the Kalman filter
  float vy = 0;
  float qa = 0;  // 1/px^2, ellipse of the gate: qa dx^2 + 2 qb dx dy + qc dy^2 <= 1
  float qb = 0;
  float qc = 0;
  float inverse_circle2 = 0;  // 1/px^2, circle of the gate
  float sxx = 0;              // px^2, covariance of the events
  float sxy = 0;
  float syy = 0;
  float mean_weight = 1;  // [w] of the plain mean against the contour
  Stamp stamp = 0;
  std::uint32_t events = 0;  // [n]
  std::int32_t id = -1;
  std::uint16_t generation = 0;
  std::uint8_t partners = 0;  // [np] clusters that it touches
  Phase phase = Phase::kFree;

  bool has_id() const noexcept { return phase >= Phase::kConfirmed; }
};
static_assert(sizeof(Track) == 64);

struct KalmanState {
  float x = 0;  // px, at `stamp`
  float y = 0;
  float pxx = 9;  // px^2; one covariance for both axes
  float pxv = 0;
  float pvv = 1e4F;
  Stamp stamp = 0;
  std::uint32_t events = 0;  // of the track, at the last update
};

struct MergeState {
  static constexpr std::uint16_t kNobody = 0xffff;

  std::uint16_t partner = kNobody;
  std::uint16_t generation = 0;  // of the partner
  float hold_s = 0;              // for which the relative position has been constant
  float travel_px = 0;           // meanwhile
  float dx = 0;                  // px, the relative position then
  float dy = 0;
};

// How the halves of a track that looks like two objects lay to each other; none seen: no distance.
struct HalvesSeen {
  float dx = 0;  // px
  float dy = 0;
  float at_s = 0;  // age of the track
};

struct Life {
  float age_s = 0;
  float confirmed_s = 0;  // since it was confirmed
  float coasting_s = 0;
  float starved_s = 0;  // [sf]
  float mass = 0;       // recent events
  float fast_rate_hz = 0;
  float slow_rate_hz = 0;
  float evidence = 0;        // [llr] for an object against noise
  float double_s = 0;        // for which it has looked like two objects
  float extent_px = 0;       // [ext] largest standard deviation
  float usual_extent2 = 0;   // px^2 [lref]
  std::uint32_t events = 0;  // of the track, at the last tick
  Stamp last_event = 0;      // up to the last tick
  KalmanState kalman;
  MergeState merge;
  HalvesSeen halves;
  std::array<std::uint16_t, kMaxPartners> partners{};
  std::uint16_t sibling = MergeState::kNobody;
  std::uint16_t sibling_generation = 0;
  float seen_x = 0;  // px, where it was when it had events
  float seen_y = 0;
  float usual_vx = 0;  // px/s, then
  float usual_vy = 0;
  bool near_confirmed = true;    // in reach of a confirmed one, or nobody has looked yet
  bool may_be_fragment = false;  // of one
};

class Tracks {
 public:
  using Slot = std::uint16_t;
  static constexpr Slot kNone = 0xffff;

  explicit Tracks(std::size_t slots) : tracks_(slots), contours_(slots), lives_(slots) {
    free_.reserve(slots);
    active_.reserve(slots);
    clear();
  }

  // Generations go on, so that what was noted before stays void.
  void clear() noexcept {
    free_.clear();
    active_.clear();
    for (std::size_t slot = tracks_.size(); slot-- > 0;) {
      tracks_[slot].phase = Phase::kFree;
      ++tracks_[slot].generation;
      free_.push_back(static_cast<Slot>(slot));
    }
  }

  // A tentative track at a pixel, or kNone when the table is full.
  Slot create(float x, float y, Stamp now) noexcept {
    if (free_.empty()) return kNone;
    const Slot slot = free_.back();
    free_.pop_back();
    active_.push_back(slot);
    const std::uint16_t generation = tracks_[slot].generation;
    tracks_[slot] = {};
    tracks_[slot].x = x;
    tracks_[slot].y = y;
    tracks_[slot].stamp = now;
    tracks_[slot].generation = generation;
    tracks_[slot].phase = Phase::kTentative;
    contours_[slot] = {};
    lives_[slot] = {};
    lives_[slot].last_event = now;
    lives_[slot].kalman.x = x;
    lives_[slot].kalman.y = y;
    lives_[slot].kalman.stamp = now;
    return slot;
  }

  void remove(Slot slot) noexcept {
    tracks_[slot].phase = Phase::kFree;
    ++tracks_[slot].generation;
    free_.push_back(slot);
    for (std::size_t i = 0; i < active_.size(); ++i) {
      if (active_[i] != slot) continue;
      active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(i));
      return;
    }
  }

  Track& operator[](std::size_t slot) noexcept { return tracks_[slot]; }
  const Track& operator[](std::size_t slot) const noexcept { return tracks_[slot]; }
  Contour& contour(std::size_t slot) noexcept { return contours_[slot]; }
  const Contour& contour(std::size_t slot) const noexcept { return contours_[slot]; }
  Life& life(std::size_t slot) noexcept { return lives_[slot]; }
  const Life& life(std::size_t slot) const noexcept { return lives_[slot]; }

  // Oldest first.
  const std::vector<Slot>& active() const noexcept { return active_; }

 private:
  std::vector<Track> tracks_;
  std::vector<Contour> contours_;
  std::vector<Life> lives_;
  std::vector<Slot> free_;
  std::vector<Slot> active_;
};

}  // namespace asap::fast
