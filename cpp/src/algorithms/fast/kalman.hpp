// Kalman filter with constant velocity over the means of a track: white acceleration whose density
// grows with the cube of the speed, so that slow objects are smoothed and fast ones followed. One
// covariance serves both axes. PositionError adds what the filter cannot know: all means are taken
// about one outline, whose centre is that of the edges which have fired. Averaging does not remove
// this error. It is a fraction of the events' covariance, large for a new track; it shrinks while
// the object travels over its own length and grows in contact, where a neighbour's events pull at
// an outline that does not learn. One thread, at the tick. O(1), no allocation. Source: own design;
// the fractions were fitted to the errors on the scenes A to G, seeds 100 to 102.
#pragma once

#include <cstdint>

#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

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
void update_centre_variance(const Track& track, TrackState& state, float dt_s) noexcept;

struct PositionError {
  float xx;  // px^2, covariance
  float xy;
  float yy;
};

PositionError position_error(const Track& track, const TrackState& state, Stamp now) noexcept;

}  // namespace asap::inline v0_1::fast
