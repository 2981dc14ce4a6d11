#include "algorithms/cluster_motion.hpp"

#include <algorithm>

#include "algorithms/fast/track.hpp"
#include "asap/algorithms/cluster_tracker.hpp"

namespace asap {

void ClusterMotion::begin(Vector2 centre, std::int64_t t_us) noexcept {
  *this = {};
  state_.x = static_cast<float>(centre.x);
  state_.y = static_cast<float>(centre.y);
  measured_us_ = t_us;
}

void ClusterMotion::measure(const WindowMoments& moments) noexcept {
  if (events_ < fast::kKalmanEvents) return;
  const auto n = static_cast<float>(events_);
  const std::int64_t age = ages_ / static_cast<std::int64_t>(events_);
  const Covariance spread = moments.covariance();

  fast::Track mean;
  mean.x = static_cast<float>(x_) / n;
  mean.y = static_cast<float>(y_) / n;
  mean.vx = static_cast<float>(velocity_.x);
  mean.vy = static_cast<float>(velocity_.y);
  mean.sxx = static_cast<float>(spread.xx);
  mean.syy = static_cast<float>(spread.yy);
  mean.stamp = state_.stamp + static_cast<fast::Stamp>(age);
  mean.events = state_.events + events_;
  fast::kalman_update(mean, state_, 0, events_);

  velocity_ = {mean.vx, mean.vy};
  measured_us_ += age;
  events_ = 0;
  x_ = 0;
  y_ = 0;
  ages_ = 0;
}

Vector2 ClusterMotion::position_at(std::int64_t t_us) const noexcept {
  const std::int64_t ahead_us = std::clamp(since_measured(t_us), std::int64_t{0}, kMaxAhead_us);
  const double ahead_s = 1e-6 * static_cast<double>(ahead_us);
  return {static_cast<double>(state_.x) + velocity_.x * ahead_s,
          static_cast<double>(state_.y) + velocity_.y * ahead_s};
}

}  // namespace asap
