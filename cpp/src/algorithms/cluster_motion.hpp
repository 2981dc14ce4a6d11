// ClusterMotion: position and velocity of one cluster by a Kalman filter with constant velocity.
// The measurement is the mean of the events since the one before, taken once their mean age is a
// millisecond and they are eight; so neither the window nor the weight of the rule matters. After a
// second without one the filter begins anew: its velocity is history by then. One thread. take() is
// O(1) and allocates nothing. Source: own design, the filter of ClusterTracker (fast/track.hpp).
#pragma once

#include <cstdint>

#include "algorithms/fast/track.hpp"
#include "algorithms/window_moments.hpp"

namespace asap {

class ClusterMotion {
 public:
  static constexpr std::int64_t kTick_us = 1000;
  static constexpr std::int64_t kSilence_us = 1'000'000;
  static constexpr std::int64_t kMaxAhead_us = 100'000;

  // Starts at rest in `centre`, px.
  void begin(Vector2 centre, std::int64_t t_us) noexcept;

  // The cluster has taken an event; `moments`: of its live events, this one included.
  // Precondition: begun.
  void take(std::uint64_t x, std::uint64_t y, std::int64_t t_us,
            const WindowMoments& moments) noexcept {
    const std::int64_t age = since_measured(t_us);
    if (age > kSilence_us || age < -kSilence_us) return begin(moments.centroid(), t_us);
    events_ += 1;
    x_ += x;
    y_ += y;
    ages_ += age;
    if (ages_ >= kTick_us * static_cast<std::int64_t>(events_)) measure(moments);
  }

  // px, as predicted for `t_us`: not the past, and no more than kMaxAhead_us ahead.
  Vector2 position_at(std::int64_t t_us) const noexcept;

  // px/s
  Vector2 velocity() const noexcept { return velocity_; }

 private:
  // Wraps for stamps that are centuries apart.
  std::int64_t since_measured(std::int64_t t_us) const noexcept {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(t_us) -
                                     static_cast<std::uint64_t>(measured_us_));
  }

  void measure(const WindowMoments& moments) noexcept;

  fast::KalmanState state_;
  Vector2 velocity_{};  // px/s
  std::int64_t measured_us_ = 0;
  // Sums over the events since then.
  std::uint32_t events_ = 0;
  std::uint64_t x_ = 0;
  std::uint64_t y_ = 0;
  std::int64_t ages_ = 0;  // us
};

}  // namespace asap
