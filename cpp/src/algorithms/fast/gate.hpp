// The gate of a track: which events it accepts. A circle around the predicted mean, or the ellipse
// of the covariance, whichever is wider in the event's direction. A young track has the circle of a
// birth only. Where it is alone, that is as wide as noise and its own events allow, so that a large
// object is born whole. The circle and ellipse of a mature one follow its size. One setting serves
// objects of radius 3 to 35 px. One thread; gate_value() per event, the rest at the tick. O(1), no
// allocation.
// Source: own design.
#pragma once

#include <algorithm>

#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

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
// large track has a wider ellipse for 200 ms, which reaches it up to 2.8 of them. A small track has
// not: in a crowd it would take events of others.

// Notes that a fragment lies at this displacement, or its opposite, from the track.
void note_fragment(const Track& track, TrackState& state, float dx, float dy) noexcept;

// Half-axes of the ellipse, standard deviations.
float ellipse_scale(const TrackState& state) noexcept;

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

// A circle that accepts needs no ellipse.
inline bool accepts(const Track& track, const Innovation& nu) noexcept {
  return (nu.dx * nu.dx + nu.dy * nu.dy) * track.inverse_circle2 <= 1 || gate_value(track, nu) <= 1;
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

}  // namespace asap::inline v0_1::fast
