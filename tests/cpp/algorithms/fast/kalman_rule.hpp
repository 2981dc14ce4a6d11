// The rule by which tests let the Kalman filter follow.
#pragma once

#include "algorithms/fast/kalman.hpp"

namespace asap::fast {

inline constexpr KalmanRule kRule{.acceleration = 5e3F,
                                  .per_speed3 = 0.055F,
                                  .most = 1e7F,
                                  .contact = 5e3F,
                                  .measurement_scale = 4,
                                  .min_measurement_px2 = 0.05F,
                                  .mean_events = 60};

}  // namespace asap::fast
