// Centroid, covariance and velocity of a set of events from their definitions, in long double.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "algorithms/window_moments.hpp"
#include "asap/core/event.hpp"

namespace asap::test {

struct BruteForce {
  long double n = 0, x = 0, y = 0, t = 0;                      // means; t from the first event
  long double xx = 0, xy = 0, yy = 0, tt = 0, xt = 0, yt = 0;  // central sums

  template <class Events>
  explicit BruteForce(const Events& events) {
    const std::int64_t start = events.front().t;
    for (const Event& e : events) {
      n += 1;
      x += e.x;
      y += e.y;
      t += static_cast<long double>(e.t - start);
    }
    x /= n;
    y /= n;
    t /= n;
    for (const Event& e : events) {
      const long double dx = e.x - x;
      const long double dy = e.y - y;
      const long double dt = static_cast<long double>(e.t - start) - t;
      xx += dx * dx;
      xy += dx * dy;
      yy += dy * dy;
      tt += dt * dt;
      xt += dx * dt;
      yt += dy * dt;
    }
  }
};

inline void expect_close(double value, long double expected, const char* name) {
  const double scale = std::max(1.0, std::abs(static_cast<double>(expected)));
  EXPECT_NEAR(value, static_cast<double>(expected), 1e-11 * scale) << name;
}

// `velocity` in px/us.
inline void expect_moments(const Vector2& centroid, const Covariance& covariance,
                           const Vector2& velocity, const BruteForce& truth) {
  expect_close(centroid.x, truth.x, "x");
  expect_close(centroid.y, truth.y, "y");
  expect_close(covariance.xx, truth.xx / truth.n, "cxx");
  expect_close(covariance.xy, truth.xy / truth.n, "cxy");
  expect_close(covariance.yy, truth.yy / truth.n, "cyy");
  // In units of one standard deviation per span, so that slow windows are not compared with zero.
  const long double span = std::sqrt(truth.tt);
  expect_close(velocity.x * static_cast<double>(span), truth.tt > 0 ? truth.xt / span : 0, "vx");
  expect_close(velocity.y * static_cast<double>(span), truth.tt > 0 ? truth.yt / span : 0, "vy");
}

}  // namespace asap::test
