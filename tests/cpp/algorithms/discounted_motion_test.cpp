#include "algorithms/discounted_motion.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/random.hpp"

namespace discounted_motion_test {
namespace {

using asap::DiscountedMotion;

TEST(DiscountedMotion, OfALineIsExact) {
  DiscountedMotion motion;
  double t = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double dt = i % 3 * 1.5;
    t += dt;
    motion.add(7 + 0.25 * t, 1000 - 3 * t, dt, 20);
  }
  EXPECT_NEAR(motion.velocity().x, 0.25, 1e-9);
  EXPECT_NEAR(motion.velocity().y, -3, 1e-9);
}

TEST(DiscountedMotion, IsTheWeightedRegression) {
  constexpr double kMemory = 12;
  const asap::CounterRandom random(4);
  struct Point {
    double x, y, t, weight;
  };
  std::vector<Point> points;
  DiscountedMotion motion;
  double t = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const double dt = 5 * random.uniform(3 * i);
    t += dt;
    for (Point& point : points) point.weight *= kMemory / (kMemory + dt);
    points.push_back({40 * random.uniform(3 * i + 1), 40 * random.uniform(3 * i + 2), t, 1});
    motion.add(points.back().x, points.back().y, dt, kMemory);
  }
  Point mean{};
  for (const Point& p : points) {
    mean.weight += p.weight;
    mean.x += p.weight * p.x;
    mean.y += p.weight * p.y;
    mean.t += p.weight * p.t;
  }
  double tt = 0, xt = 0, yt = 0;
  for (const Point& p : points) {
    const double age = p.t - mean.t / mean.weight;
    tt += p.weight * age * age;
    xt += p.weight * age * (p.x - mean.x / mean.weight);
    yt += p.weight * age * (p.y - mean.y / mean.weight);
  }
  EXPECT_NEAR(motion.velocity().x, xt / tt, 1e-9);
  EXPECT_NEAR(motion.velocity().y, yt / tt, 1e-9);
}

TEST(DiscountedMotion, IsZeroAtASingleTime) {
  DiscountedMotion motion;
  EXPECT_EQ(motion.velocity().x, 0);
  motion.add(3, 4, 0, 1);
  motion.add(300, -4, 0, 1);
  EXPECT_EQ(motion.velocity().x, 0);
  EXPECT_EQ(motion.velocity().y, 0);
}

}  // namespace
}  // namespace discounted_motion_test
