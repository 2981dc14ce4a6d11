// The gate of a track: which events it takes. A circle around the predicted mean, or the ellipse of
// the covariance, whichever is wider in the event's direction. A young track has the circle of a
// birth only; a grown one's circle and ellipse follow its size, so that one setting serves radius 3
// to 20 px. Per event O(1) and inline, shaped at the tick. No allocation.
// Source: own design.
#pragma once

#include <algorithm>
#include <cmath>

#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

inline float length(float x, float y) noexcept { return std::sqrt(x * x + y * y); }

// Where an event lies as a track sees it.
struct Sight {
  float mean_x;  // px, predicted for now
  float mean_y;
  float dx;  // px, from there to the event
  float dy;
};

inline Sight sight_of(const Track& track, Stamp now, float x, float y) noexcept {
  const float dt_s = 1e-6F * static_cast<float>(age_us(now, track.stamp));
  const float mean_x = track.x + track.vx * dt_s;
  const float mean_y = track.y + track.vy * dt_s;
  return {mean_x, mean_y, x - mean_x, y - mean_y};
}

// 0 in the centre; the gate takes what is at most 1.
inline float gate_value(const Track& track, const Sight& s) noexcept {
  const float circle = (s.dx * s.dx + s.dy * s.dy) * track.inverse_circle2;
  const float ellipse =
      s.dx * s.dx * track.qa + 2 * s.dx * s.dy * track.qb + s.dy * s.dy * track.qc;
  return std::min(circle, ellipse);
}

struct GateRule {
  float birth_radius_px;    // [Rb]
  float min_radius_px;      // [Rmin]
  float max_radius_px;      // [Rmax]
  float scale;              // [g]
  float padding_px;         // [s0]
  float circle_scale;       // [rk]
  float circle_padding_px;  // [r0]
};

// The larger eigenvalue of the covariance.
float largest_variance(const Track& track) noexcept;

// The gate of a newborn: the circle alone.
void shape_birth_gate(Track& track, const GateRule& rule) noexcept;

// That of a confirmed track. `mature`: the circle follows the extent. `doubt_px2`: variance of the
// position, of a track that sees no events.
void shape_gate(Track& track, const GateRule& rule, float largest_variance_px2, bool mature,
                float doubt_px2) noexcept;

// px^2 that the gate covers, where noise counts as the track's.
float gate_area(const Track& track, const GateRule& rule, bool mature) noexcept;

}  // namespace asap::fast
