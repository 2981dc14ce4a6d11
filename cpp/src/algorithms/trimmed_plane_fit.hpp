// TrimmedPlaneFit: the plane t = a x + b y + c through the times of a 7 x 7 window, by weighted
// least squares: a pixel 2 px from the centre counts half. Twice, the points farther from the plane
// than 1.5 times their rms distance are dropped. What is left must be one edge: it lies within
// 0.7 px rms of the plane, measured along the edge's normal. One thread; O(49), no allocation.
// Source: Benosman, Clercq, Lagorce, Ieng, Bartolozzi, "Event-Based Visual Flow", IEEE TNNLS 2014;
// the weights and the test of the fit are ours.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "algorithms/plane_fit.hpp"
#include "algorithms/recent_times.hpp"

namespace asap::inline v0_1 {

struct WindowPixel;

class TrimmedPlaneFit {
 public:
  using Time = RecentTimes::Time;
  static constexpr std::ptrdiff_t kReach = 3;  // px from the centre
  static constexpr std::size_t kSide = 2 * kReach + 1;

  // The times of at most `window_us` before that of the centre, which is the newest.
  TrimmedPlaneFit(const Time* centre, std::ptrdiff_t stride, Time window_us) noexcept;

  // False if fewer than `min_points` are left, if they lie on a line or if they are not one edge.
  bool fit(std::size_t min_points, TimePlane& plane) noexcept;

 private:
  struct Point {
    const WindowPixel* pixel;
    double t;       // us, from that of the centre
    double square;  // us^2, of the distance from the plane
  };

  std::span<Point> points() noexcept { return {points_.data(), size_}; }
  void add(const Point& point, double times) noexcept;
  bool solve(TimePlane& plane) const noexcept;
  double mean_square(const TimePlane& plane) noexcept;  // us^2
  bool drop_outliers(double mean_square) noexcept;

  std::array<Point, kSide * kSide> points_;
  std::size_t size_ = 0;
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();  // the normal equations of the points
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

}  // namespace asap::inline v0_1
