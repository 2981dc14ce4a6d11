// Track: one cluster of the tracker. What every event touches stands in its 64 bytes, what only the
// tick touches in TrackState. Tracks is the table of them, each with its contour. A slot that is
// freed changes its generation, so that a reference with the old generation is known to be stale.
// One thread. O(1), but for clear() and remove(), which are O(slots); allocates in the constructor
// only. Source: own design.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/contour.hpp"
#include "algorithms/fast/time.hpp"
#include "asap/core/event.hpp"

namespace asap::inline v0_1::fast {

inline constexpr std::size_t kMaxPartners = 3;
inline constexpr std::size_t kMaxCandidates = 4;  // candidates of one track for a merge
inline constexpr std::uint16_t kNoSlot = 0xffff;
inline constexpr float kInitialCentreVariance = 0.05F;

enum class Phase : std::uint8_t {
  kFree,
  kTentative,  // may be noise: no id, not listed
  kConfirmed,
  kCoasting,  // was confirmed and has too few events now: keeps id and gate for a while
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
  float mean_weight = 1;  // weight of the plain mean against the contour
  Stamp stamp = 0;
  std::uint32_t events = 0;
  std::int32_t id = -1;
  std::uint16_t generation = 0;
  std::uint8_t partners = 0;  // tracks in contact with this one
  Phase phase = Phase::kFree;

  bool has_id() const noexcept { return phase >= Phase::kConfirmed; }
};
static_assert(sizeof(Track) == 64);

inline float length(float x, float y) noexcept { return std::sqrt(x * x + y * y); }

struct Point {
  float x;  // px
  float y;
};

inline Point predicted_mean(const Track& track, Stamp now) noexcept {
  const float dt_s = age_s(now, track.stamp);
  return {track.x + track.vx * dt_s, track.y + track.vy * dt_s};
}

// Standard deviation of the events along a direction, at least a pixel.
inline float spread_along(const Track& track, float ux, float uy) noexcept {
  return std::sqrt(
      std::max(1.0F, ux * ux * track.sxx + 2 * ux * uy * track.sxy + uy * uy * track.syy));
}

// An event's position minus the mean that the track predicts for its time.
struct Innovation {
  float mean_x;  // px, predicted
  float mean_y;
  float dx;  // px, from there to the event
  float dy;
};

inline Innovation innovation_of(const Track& track, Stamp now, const Event& event) noexcept {
  const Point mean = predicted_mean(track, now);
  return {mean.x, mean.y, static_cast<float>(event.x) - mean.x,
          static_cast<float>(event.y) - mean.y};
}

struct KalmanState {
  float x = 0;  // px, at `stamp`
  float y = 0;
  float pxx = 9;  // px^2; one covariance for both axes
  float pxv = 0;
  float pvv = 1e4F;
  Stamp stamp = 0;
  std::uint32_t events = 0;  // the track's at the last update
};

// The time for which a track and a candidate for a merge have kept their relative position.
struct MergeState {
  std::uint16_t other = kNoSlot;
  std::uint16_t generation = 0;  // the other's
  float hold_s = 0;              // time for which the relative position has been constant
  float travel_px = 0;           // way of that time
  float dx = 0;                  // px, the relative position at the start
  float dy = 0;
};

// Offset between the two halves of a track that may be two objects; zero: not seen yet.
struct HalvesOffset {
  float dx = 0;  // px
  float dy = 0;
  float at_s = 0;  // age of the track
};

// "Starved": the track gets far fewer events than its average rate.
struct TrackState {
  float age_s = 0;
  float confirmed_s = 0;  // since it was confirmed
  float coasting_s = 0;
  float starved_s = 0;
  float mass = 0;  // recent events
  float fast_rate_hz = 0;
  float slow_rate_hz = 0;
  float gate_scale = 0;       // half-axes of the gate's ellipse, standard deviations
  float fragment_scale = 0;   // those with which it contains the fragments that began beside it
  float fragment_s = 1;       // since the last of them began
  float evidence = 0;         // log-likelihood ratio of an object against noise
  float young_radius_px = 0;  // radius of the gate's circle until the track is mature
  float unresolved_s = 0;     // time for which it has looked like two objects
  float extent_px = 0;        // largest standard deviation of the events
  float average_extent2 = 0;  // px^2, slow average of extent_px^2 while no other object is near
  std::uint32_t events = 0;   // the track's at the last tick
  Stamp last_event = 0;       // up to the last tick
  KalmanState kalman;
  std::array<MergeState, kMaxCandidates> merges{};  // the last updated first
  HalvesOffset halves;
  std::array<std::uint16_t, kMaxPartners> partners{};
  std::uint16_t sibling = kNoSlot;  // a track that may be part of the same object
  std::uint16_t sibling_generation = 0;
  std::uint32_t mean_events = kMeanEvents;  // memory of the mean since the last tick
  float last_seen_x = 0;                    // px, at the last tick with enough events
  float last_seen_y = 0;
  float average_vx = 0;  // px/s, of such ticks
  float average_vy = 0;
  // Variance of the error of the outline's centre, as a fraction of the covariance of the events.
  float centre_variance = kInitialCentreVariance;
  bool near_confirmed = true;    // a confirmed track is in reach, or it is not known yet
  bool may_be_fragment = false;  // it may belong to a confirmed track
};

class Tracks {
 public:
  using Slot = std::uint16_t;
  static constexpr Slot kNone = kNoSlot;

  explicit Tracks(std::size_t slots) : tracks_(slots), contours_(slots), states_(slots) {
    free_.reserve(slots);
    active_.reserve(slots);
    clear();
  }

  // Generations go on, so that old references stay stale.
  void clear() noexcept {
    free_.clear();
    active_.clear();
    for (std::size_t slot = tracks_.size(); slot-- > 0;) {
      tracks_[slot].phase = Phase::kFree;
      ++tracks_[slot].generation;
      free_.push_back(static_cast<Slot>(slot));
    }
  }

  // A tentative track at a position, or kNone when the table is full.
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
    states_[slot] = {};
    states_[slot].last_event = now;
    states_[slot].kalman.x = x;
    states_[slot].kalman.y = y;
    states_[slot].kalman.stamp = now;
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
  TrackState& state(std::size_t slot) noexcept { return states_[slot]; }
  const TrackState& state(std::size_t slot) const noexcept { return states_[slot]; }

  // Oldest first.
  const std::vector<Slot>& active() const noexcept { return active_; }

 private:
  std::vector<Track> tracks_;
  std::vector<Contour> contours_;
  std::vector<TrackState> states_;
  std::vector<Slot> free_;
  std::vector<Slot> active_;
};

}  // namespace asap::inline v0_1::fast
