// Kalman filter with constant velocity over the means of a track: white acceleration whose density
// grows with the cube of the speed, so that slow objects are smoothed and fast ones followed. One
// covariance serves both axes. Called at the tick. O(1), no allocation.
// Source: own design.
#pragma once

#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

struct KalmanRule {
  float acceleration;              // [q0] px^2/s^3
  float per_speed3;                // [q1] 1/px
  float most;                      // [qmax] px^2/s^3
  float contact;                   // [qc] px^2/s^3
  float measurement_scale;         // [rscale]
  float min_measurement_px2;       // [rmin]
  std::uint32_t mean_events = 60;  // [n_eff]
};

inline constexpr std::uint32_t kKalmanEvents = 8;  // that are new at an update

// Takes the track's mean as a measurement, if enough events are new, and sets its velocity.
void kalman_update(Track& track, KalmanState& state, float contour_variance,
                   const KalmanRule& rule) noexcept;

// px^2, of the position along each axis, predicted for `now`.
float position_variance(const Track& track, const KalmanState& state, Stamp now,
                        const KalmanRule& rule) noexcept;

// Without events: the velocity decays with the time constant, mean and state move on with it to
// `now`, the covariance grows up to kMaxVariance_px2.
inline constexpr float kMaxVariance_px2 = 100;
void kalman_starve(Track& track, KalmanState& state, Stamp now, float velocity_decay_s) noexcept;

}  // namespace asap::fast
