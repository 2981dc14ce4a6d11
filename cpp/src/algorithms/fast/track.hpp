// Track: one cluster of the fast tracker, and how it follows its events: the outline that it
// learns, the gate of the events that it accepts, the update of mean and covariance per event, the
// Kalman filter at the tick. What every event touches stands in the 64 bytes of Track, the contour
// beside it, and what only the tick touches in TrackState. One thread. O(1), but for
// Tracks::clear() and remove(), which are O(slots); allocates in constructors only. Source: own
// design.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/constants.hpp"
#include "algorithms/fast/time.hpp"

namespace asap::fast {

// ---- contour -----------------------------------------------------------------------------------

// Contour: the outline of an object as a radius per direction, in 16 bins, and the variance of the
// events about it. The edges of an object fire unevenly, so the plain mean of its events wobbles;
// the radial residual, distance minus radius of that direction, does not. One thread. O(1), no
// allocation.
// Source: own design.

inline constexpr std::size_t kContourBins = 16;

struct alignas(32) Contour {
  static constexpr float kInitialVariance_px2 = 4;
  static constexpr float kVarianceMemory = 64;  // events
  static constexpr float kInitialCentreVariance = 0.05F;

  std::array<float, kContourBins> radius{};
  std::array<std::uint8_t, kContourBins> count{};
  float variance = kInitialVariance_px2;  // px^2, of the residuals
  float polarity = 0;                     // mean, OFF = -1, ON = 1
  // Variance of the centre's error, as a fraction of the covariance of the events.
  float centre_variance = kInitialCentreVariance;
  std::uint32_t mean_events =
      kMeanEvents;  // memory of the mean, by size; here because every event reads it

  bool known(std::size_t bin) const noexcept { return count[bin] >= kKnownContourEvents; }

  // Distance of an event from the outline, positive outside.
  float residual(std::size_t bin, float distance) const noexcept { return distance - radius[bin]; }

  void learn(std::size_t bin, float distance) noexcept {
    const float outwards = residual(bin, distance);
    const float clipped = std::clamp(outwards, -kContourClip_px, kContourClip_px);
    if (known(bin)) variance += (clipped * clipped - variance) / kVarianceMemory;
    count[bin] = std::min<std::uint8_t>(kContourEvents, static_cast<std::uint8_t>(count[bin] + 1));
    radius[bin] += outwards / static_cast<float>(count[bin]);
  }

  void forget_radius() noexcept {
    count.fill(0);
    centre_variance = kInitialCentreVariance;
  }
};

// The direction bin of a displacement, by table: rounded to px and clamped to +-32.
class DirectionTable {
 public:
  DirectionTable();

  std::size_t bin(float dx, float dy) const noexcept {
    return bins_[index(dy) * kSide + index(dx)];
  }

 private:
  static constexpr int kReach = 32;
  static constexpr std::size_t kSide = 2 * kReach;

  static std::size_t index(float d) noexcept {
    constexpr float kLimit = kReach;
    return static_cast<std::size_t>(std::clamp(d, -kLimit, kLimit - 1) + (kLimit + 0.5F));
  }

  std::array<std::uint8_t, kSide * kSide> bins_;
};

// ---- tracks ------------------------------------------------------------------------------------

// Tracks is the table of them. A slot that is freed changes its generation, so that a reference
// with the old generation is known to be stale.

inline constexpr std::size_t kMaxPartners = 3;
inline constexpr std::size_t kMaxCandidates = 4;  // candidates of one track for a merge
inline constexpr std::uint16_t kNoSlot = 0xffff;

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

inline Innovation innovation_of(const Track& track, Stamp now, float x, float y) noexcept {
  const Point mean = predicted_mean(track, now);
  return {mean.x, mean.y, x - mean.x, y - mean.y};
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
  float last_seen_x = 0;  // px, at the last tick with enough events
  float last_seen_y = 0;
  float average_vx = 0;  // px/s, of such ticks
  float average_vy = 0;
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

// ---- gate --------------------------------------------------------------------------------------

// The gate of a track: which events it accepts. A circle around the predicted mean, or the ellipse
// of the covariance, whichever is wider in the event's direction. A young track has the circle of a
// birth only. Where it is alone, that is as wide as noise and its own events allow, so that a large
// object is born whole. The circle and ellipse of a mature one follow its size. One setting serves
// objects of radius 3 to 35 px. One thread; gate_value() per event, the rest at the tick. O(1), no
// allocation.
// Source: own design.

struct GateRule {
  float birth_radius_px;     // narrowest circle of a young track, widest of a mature one
  float max_radius_px;       // longest half-axis of the ellipse
  float noise_events = 0;    // maximum of noise in a young track's mass
  float min_density_hz = 0;  // events per pixel of its circle, from which an object fills it
};

// The widest circle of a young track, as a factor on the narrowest. Wider ones take events of the
// neighbours.
inline constexpr float kWidestBirth = 5.0F / 3;

// px, extent from which a track is large: the gate may miss parts of its object, or it may itself
// be a part of one that the gate cuts into several.
inline constexpr float kLarge_px = 8.5F;

// The parts of an object that the gate misses, such as the tips of an L, 2.45 standard deviations
// from its centre, would be tracks of their own again and again. So where a fragment has begun, a
// large track has a wider ellipse for 200 ms, which reaches it up to 2.8 of them, unless many of
// its events, a share, are noise. A small track has not: in a crowd it would take events of others.

// Notes that a fragment lies at this displacement, or its opposite, from the track.
void note_fragment(const Track& track, TrackState& state, float dx, float dy) noexcept;

// Half-axes of the ellipse, standard deviations.
float ellipse_scale(const TrackState& state, float noise_share) noexcept;

// px, of a young track's circle: the widest in which noise of this rate per pixel stays below the
// rule's number of events in a mass.
float widest_radius(const GateRule& rule, float noise_hz) noexcept;

// px, of the circle of a track that is not mature: the narrowest beside a confirmed track, whose
// events a wider one would take; else widest_px, but narrower from 3 ms on if its events are too
// few to come from an object of that size.
float young_radius(const TrackState& state, const GateRule& rule, float widest_px) noexcept;

// The normalised distance, 0 in the centre; the gate accepts values up to 1.
inline float gate_value(const Track& track, const Innovation& nu) noexcept {
  const float circle = (nu.dx * nu.dx + nu.dy * nu.dy) * track.inverse_circle2;
  const float ellipse =
      nu.dx * nu.dx * track.qa + 2 * nu.dx * nu.dy * track.qb + nu.dy * nu.dy * track.qc;
  return std::min(circle, ellipse);
}

// px^2, the larger eigenvalue of the covariance.
float largest_variance(const Track& track) noexcept;

// Sets the gate of a tentative track: the circle alone.
void shape_birth_gate(Track& track, float radius_px) noexcept;

// Sets the gate of a confirmed track. `scale`: ellipse_scale(). `young_px`: its circle until it is
// mature. `mature`: the circle follows the extent. `position_variance_px2`: that of the predicted
// position, for a track without events.
void shape_gate(Track& track, const GateRule& rule, float scale, float young_px,
                float largest_variance_px2, bool mature, float position_variance_px2) noexcept;

// px^2 of the gate, of a mature one without what ellipse_scale() adds: noise on this area counts as
// the track's events.
float young_gate_area(float radius_px) noexcept;
float mature_gate_area(const Track& track) noexcept;

// ---- Kalman filter -----------------------------------------------------------------------------

// Kalman filter with constant velocity over the means of a track: white acceleration whose density
// grows with the cube of the speed, so that slow objects are smoothed and fast ones followed. One
// covariance serves both axes. PositionError adds what the filter cannot know: all means are taken
// about one outline, whose centre is that of the edges which have fired. Averaging does not remove
// this error. It is a fraction of the events' covariance, large for a new track; it shrinks while
// the object travels over its own length and grows in contact, where a neighbour's events pull at
// an outline that does not learn. One thread, at the tick. O(1), no allocation. Source: own design;
// the fractions were fitted to the errors on the scenes A to G, seeds 100 to 102.

inline constexpr std::uint32_t kKalmanEvents = 8;  // new events that an update needs

// Takes the track's mean as a measurement, if enough events are new, and sets its velocity.
// `mean_events`: its memory.
void kalman_update(Track& track, KalmanState& state, float contour_variance,
                   std::uint32_t mean_events) noexcept;

// Moves a starved track to `now`: the velocity decays, mean and state move
// with it, and the covariance grows up to kMaxVariance_px2.
inline constexpr float kMaxVariance_px2 = 100;
void kalman_without_events(Track& track, KalmanState& state, Stamp now) noexcept;

// ---- the error of the outline's centre ----

inline constexpr float kMinCentreVariance = 0.002F;

// Updates the variance after dt_s more with events.
void update_centre_variance(Contour& contour, const Track& track, float extent_px,
                            float dt_s) noexcept;

struct PositionError {
  float xx;  // px^2, covariance
  float xy;
  float yy;
};

PositionError position_error(const Track& track, const KalmanState& state, const Contour& contour,
                             Stamp now) noexcept;

// ---- update per event --------------------------------------------------------------------------

// How a track takes an event: exponential mean and covariance with a memory in events. Once the
// outline is known, the innovation is blended with twice the radial residual, because edges fire
// unevenly and the plain mean wobbles with them. Where noise is common, events far from the outline
// do not count. In contact, covariance and contour are frozen, because each track would learn the
// other's edges. One thread, per event. Inline, O(1), no allocation.
// Source: own design.

// 1/n for the memories of the means.
class Reciprocals {
 public:
  explicit Reciprocals(std::uint32_t max) : values_(max + 1, 1.0F) {
    for (std::uint32_t n = 1; n <= max; ++n) values_[n] = 1 / static_cast<float>(n);
  }
  float operator[](std::uint32_t n) const noexcept { return values_[n]; }

 private:
  std::vector<float> values_;
};

struct UpdateRule {
  std::uint32_t mean_events = 0;   // memory of the mean; less with gamma
  std::uint32_t contour_mask = 0;  // the contour learns events whose number has none of these bits
  float far_weight = 1;            // weight of events far from the outline
};

// The weight of events far from the outline. If noise is rare, they belong to the object, whose
// outline is not exact or whose motion changes. noise_hz: per pixel, of what reaches the tracks.
inline float far_weight(float noise_hz) noexcept {
  constexpr float kRare_hz = 0.1F;
  constexpr float kCommon_hz = 0.5F;
  return std::clamp((kCommon_hz - noise_hz) / (kCommon_hz - kRare_hz), 0.0F, 1.0F);
}

// The memory of the mean of an object of this size: a small one moves by its own size in the time
// in which a large one has the events to average over.
inline std::uint32_t size_memory(const Track& track, const UpdateRule& rule) noexcept {
  constexpr float kPerVariance = 1.5F;  // events per px^2
  constexpr std::uint32_t kShortest = 10;
  const auto events = static_cast<std::uint32_t>(
      std::min(kPerVariance * (track.sxx + track.syy), static_cast<float>(rule.mean_events)));
  return std::max(std::min(kShortest, rule.mean_events), events);
}

// The same of a track that may be in contact: events that a neighbour causes must not pull at it.
inline std::uint32_t mean_memory(const Track& track, const Contour& contour,
                                 const UpdateRule& rule) noexcept {
  return track.partners > 0 ? rule.mean_events : contour.mean_events;
}

// The weight of the plain mean, by inverse variances. Textured objects, whose events fill their
// outline, fall back to the plain mean.
inline float mean_weight(const Track& track, const Contour& contour) noexcept {
  const float scatter = 2 * kMeanWeightScale * contour.variance;
  const float spread = 0.5F * (track.sxx + track.syy) + 0.5F;
  return std::clamp(scatter / (scatter + spread), kMinMeanWeight, 1.0F);
}

// The weight of an event by its distance from the outline: 1 up to 3 px, `far` from 6 px on.
// Textured objects, recognised by the weight of their plain mean, have events of their own there.
inline float event_weight(float residual, float mean_weight, float far) noexcept {
  constexpr float kNone_px = 6;
  constexpr float kFade_px = 3;
  const float near = (kNone_px - std::abs(residual)) * (1 / kFade_px);
  const float textured = 5 * mean_weight - 1.5F;
  return std::clamp(std::max(near, textured), far, 1.0F);
}

// Takes an event without contact.
inline void update_mean(Track& track, Contour& contour, const Innovation& nu, Stamp now, float sign,
                        const UpdateRule& rule, const Reciprocals& reciprocals,
                        const DirectionTable& directions) noexcept {
  const std::uint32_t n = ++track.events;
  const float gain = reciprocals[std::min(n, contour.mean_events)];
  const float spread_gain = reciprocals[std::min(n, kCovarianceEvents)];
  const float distance = length(nu.dx, nu.dy);
  const std::size_t bin = directions.bin(nu.dx, nu.dy);
  contour.polarity += gain * (sign - contour.polarity);

  const float residual = contour.residual(bin, distance);
  if ((n & rule.contour_mask) == 0) contour.learn(bin, distance);
  float blend = 1;
  if (n >= rule.mean_events && contour.known(bin) && distance > 0) {
    const float clipped = std::clamp(residual, -kContourClip_px, kContourClip_px);
    blend = track.mean_weight + (1 - track.mean_weight) * 2 * clipped / distance;
    blend *= event_weight(residual, track.mean_weight, rule.far_weight);
  }
  track.x = nu.mean_x + gain * blend * nu.dx;
  track.y = nu.mean_y + gain * blend * nu.dy;
  track.stamp = now;
  track.sxx += spread_gain * ((1 - gain) * nu.dx * nu.dx - track.sxx);
  track.sxy += spread_gain * ((1 - gain) * nu.dx * nu.dy - track.sxy);
  track.syy += spread_gain * ((1 - gain) * nu.dy * nu.dy - track.syy);
}

// Takes an event in contact: moves the mean alone, by the outline's residual.
inline void update_in_contact(Track& track, Contour& contour, const Innovation& nu, Stamp now,
                              float sign, const UpdateRule& rule, const Reciprocals& reciprocals,
                              const DirectionTable& directions) noexcept {
  const std::uint32_t n = ++track.events;
  const float gain = reciprocals[std::min(n, rule.mean_events)];
  const std::size_t bin = directions.bin(nu.dx, nu.dy);
  contour.polarity += gain * (sign - contour.polarity);
  float step = kContactMeanGain * gain;
  if (contour.known(bin)) {
    const float distance = length(nu.dx, nu.dy);
    const float clipped =
        std::clamp(contour.residual(bin, distance), -kContourClip_px, kContourClip_px);
    step = distance > 0 ? std::min(1.0F, 2 * kContactGain * gain) * clipped / distance : 0;
  }
  track.x = nu.mean_x + step * nu.dx;
  track.y = nu.mean_y + step * nu.dy;
  track.stamp = now;
}

}  // namespace asap::fast
