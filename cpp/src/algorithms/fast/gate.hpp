// The gate of a track: which events it accepts. A circle around the predicted mean, or the ellipse
// of the covariance, whichever is wider in the event's direction. A young track has the circle of a
// birth only; the circle and ellipse of a mature one follow its size, so that one setting serves
// objects of radius 3 to 20 px. One thread; gate_value() per event, the rest at the tick. O(1), no
// allocation.
// Source: own design.
#pragma once

#include <algorithm>

#include "algorithms/fast/track.hpp"

namespace asap::fast {

struct GateRule {
  float birth_radius_px;    // circle of a young track
  float min_radius_px;      // smallest circle of a mature one
  float max_radius_px;      // longest half-axis of the ellipse
  float scale;              // half-axes of the ellipse, standard deviations
  float padding_px;         // added to the standard deviation, in quadrature
  float circle_scale;       // circle: standard deviations of the longest axis ...
  float circle_padding_px;  // ... and px
};

// The normalised distance, 0 in the centre; the gate accepts values up to 1.
inline float gate_value(const Track& track, const Innovation& nu) noexcept {
  const float circle = (nu.dx * nu.dx + nu.dy * nu.dy) * track.inverse_circle2;
  const float ellipse =
      nu.dx * nu.dx * track.qa + 2 * nu.dx * nu.dy * track.qb + nu.dy * nu.dy * track.qc;
  return std::min(circle, ellipse);
}

// px^2, the larger eigenvalue of the covariance.
float largest_variance(const Track& track) noexcept;

// Sets the gate of a new track: the circle alone.
void shape_birth_gate(Track& track, const GateRule& rule) noexcept;

// Sets the gate of a confirmed track. `mature`: the circle follows the extent.
// `position_variance_px2`: that of the predicted position, for a track without events.
void shape_gate(Track& track, const GateRule& rule, float largest_variance_px2, bool mature,
                float position_variance_px2) noexcept;

// px^2 of the gate: noise on this area counts as the track's events.
float gate_area(const Track& track, const GateRule& rule, bool mature) noexcept;

}  // namespace asap::fast
