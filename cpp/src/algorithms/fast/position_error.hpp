// PositionError: how far a track may be from its object. The Kalman filter knows how its means
// scatter, but not that all of them are taken about one outline, whose centre is that of the edges
// which have fired: an error that no averaging removes. It is a share of the events' covariance,
// large for a newborn, that shrinks while the object passes over its own length and grows in
// contact, where a neighbour's events pull at an outline that does not learn.
// One thread. O(1), no allocation.
// Source: own design; the shares were fitted to the errors on asap.scenes A to G, seeds 100 to 102.
#pragma once

#include "algorithms/fast/contour.hpp"
#include "algorithms/fast/kalman.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

inline constexpr float kLeastDoubt = 0.002F;

// The doubt about the outline's centre after dt_s more with events.
void doubt_outline(Contour& contour, const Track& track, float extent_px, float dt_s) noexcept;

struct PositionError {
  float xx;  // px^2, covariance
  float xy;
  float yy;
};

PositionError position_error(const Track& track, const KalmanState& state, const Contour& contour,
                             Stamp now, const KalmanRule& rule) noexcept;

}  // namespace asap::fast
