// PlaneFit: the plane t = a x + b y + c through the times of a 5 x 5 window, by least squares over
// the pixels that fired lately. The sums are integers, so only the last divisions round. One
// thread; O(25), no allocation.
// Source: Benosman, Clercq, Lagorce, Ieng, Bartolozzi, "Event-Based Visual Flow", IEEE TNNLS 2014.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "algorithms/recent_times.hpp"

namespace asap::inline v0_1 {

// Around the centre of the window, whose time is 0.
struct TimePlane {
  double a;  // us/px, along x
  double b;  // us/px, along y
  double c;  // us
};

class PlaneFit {
 public:
  using Time = RecentTimes::Time;
  static constexpr std::ptrdiff_t kReach = 2;  // px from the centre
  static constexpr std::size_t kSide = 5;
  static constexpr std::size_t kLanes = 8;           // times of a row that are read, kSide are used
  static constexpr Time kMaxWindow_us = 10'000'000;  // 32-bit sums of 25 times do not overflow

  // The times of at most `window_us` before that of the centre, which is the newest.
  PlaneFit(const Time* centre, std::ptrdiff_t stride, Time window_us) noexcept;

  int points() const noexcept;

  // False if the points lie on a line.
  bool fit(TimePlane& plane) const noexcept;

  // Drops the points farther from the plane than twice the rms distance and 1 us. Returns how many.
  int drop_outliers(const TimePlane& plane) noexcept;

 private:
  using Row = std::array<std::int32_t, kLanes>;

  std::array<Row, kSide> used_;   // 1 or 0
  std::array<Row, kSide> times_;  // us since the centre's; 0 if not used
};

}  // namespace asap::inline v0_1
