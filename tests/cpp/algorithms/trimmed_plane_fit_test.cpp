#include "algorithms/trimmed_plane_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

namespace trimmed_plane_fit_test {
namespace {

using asap::TimePlane;
using asap::TrimmedPlaneFit;
using Time = TrimmedPlaneFit::Time;

constexpr Time kNever = asap::RecentTimes::kLongAgo;
constexpr std::ptrdiff_t kReach = TrimmedPlaneFit::kReach;
constexpr std::ptrdiff_t kSide = 2 * kReach + 1;
constexpr Time kWindow_us = 40'000;

// A window whose pixels fired at time_of(x, y), around the centre.
class Window {
 public:
  explicit Window(const std::function<Time(int, int)>& time_of) {
    for (int y = -kReach; y <= kReach; ++y) {
      for (int x = -kReach; x <= kReach; ++x) times_.push_back(time_of(x, y));
    }
  }

  bool fit(TimePlane& plane, std::size_t min_points = 7, Time window_us = kWindow_us) const {
    const Time* const centre = times_.data() + kReach * kSide + kReach;
    return TrimmedPlaneFit(centre, kSide, window_us).fit(min_points, plane);
  }

 private:
  std::vector<Time> times_;
};

TEST(TrimmedPlaneFit, FindsThePlaneOfAnEdge) {
  const Window window([](int x, int y) { return 1000 + 30 * x - 40 * y; });
  TimePlane plane;
  ASSERT_TRUE(window.fit(plane));
  EXPECT_NEAR(plane.a, 30, 1e-9);
  EXPECT_NEAR(plane.b, -40, 1e-9);
  EXPECT_NEAR(plane.c, 0, 1e-9);
}

TEST(TrimmedPlaneFit, FitsTheRecentPixelsOnly) {
  // The three pixels above are as old as the window.
  const Window window([](int x, int y) { return y < 0 ? 9'100 + x : 10'000 + 10 * x; });
  TimePlane plane;
  ASSERT_TRUE(window.fit(plane, 7, 890));
  EXPECT_NEAR(plane.a, 10, 1e-9);
  EXPECT_NEAR(plane.b, 0, 1e-9);
  EXPECT_TRUE(window.fit(plane, 25, 890));
  EXPECT_FALSE(window.fit(plane, 29, 890));
}

TEST(TrimmedPlaneFit, PointsOnALineHaveNoPlane) {
  TimePlane plane;
  EXPECT_FALSE(Window([](int x, int y) { return x == y ? 10 * x : kNever; }).fit(plane));
  EXPECT_FALSE(Window([](int x, int) { return x == 0 ? 0 : kNever; }).fit(plane));
  // One pixel beside the line, where it weighs least.
  EXPECT_TRUE(Window([](int x, int y) {
                return x == 0 || (x == 3 && y == 3) ? 5 * y : kNever;
              }).fit(plane));
}

TEST(TrimmedPlaneFit, DropsTheOutliersTwice) {
  // An edge, a point far off and one that shows only without the first.
  const Window window([](int x, int y) {
    if (x == 2 && y == -2) return -30'000;
    if (x == -1 && y == 2) return -4'000;
    return 1000 * x;
  });
  TimePlane plane;
  ASSERT_TRUE(window.fit(plane, 47));
  EXPECT_NEAR(plane.a, 1000, 1e-9);
  EXPECT_NEAR(plane.b, 0, 1e-9);
  EXPECT_FALSE(window.fit(plane, 48));
}

TEST(TrimmedPlaneFit, AMicrosecondIsNoOutlier) {
  const Window window([](int x, int y) { return 20 * x + (x == 2 && y == 2); });
  TimePlane plane;
  EXPECT_TRUE(window.fit(plane, 49));
}

// An edge of 1000 us/px of which every other pixel comes so much early or late: no fit is nearer.
bool passes(Time early_or_late_us) {
  const Window window([=](int x, int y) {
    const bool late = (x + y) % 2 == 0;
    return 1000 * x + (late ? early_or_late_us : -early_or_late_us);
  });
  TimePlane plane;
  return window.fit(plane);
}

TEST(TrimmedPlaneFit, RefusesWhatIsNotOneEdge) {
  EXPECT_TRUE(passes(650));
  EXPECT_FALSE(passes(700));  // 49 of 46 degrees of freedom: 0.722 px
}

TEST(TrimmedPlaneFit, ThreePointsAreNoEdge) {
  const Window window([](int x, int y) {
    return (x == 0 && y == 0) || (x == 1 && y == 0) || (x == 0 && y == 3) ? 9 * x + y : kNever;
  });
  TimePlane plane;
  EXPECT_FALSE(window.fit(plane, 4));
}

TEST(TrimmedPlaneFit, APixelTwoAwayCountsHalf) {
  // Five pixels of an edge along y; the last comes 30 us late. Weights 4/13, 1/2, 1, 1/2 (late):
  // by hand, the slope is the weighted covariance over the weighted variance.
  const auto time_of = [](int x, int y) -> Time {
    if (x < 0 || x > 1) return kNever;
    if (y == -3 || y == -2 || y == 0) return 100 * y;
    if (y == 2) return 200 + 30;
    return kNever;
  };
  double n = 0;
  double sy = 0;
  double st = 0;
  double syy = 0;
  double syt = 0;
  double sx = 0;
  double sxx = 0;
  double sxy = 0;
  double sxt = 0;
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = 0; x <= 1; ++x) {
      const Time time = time_of(x, y);
      if (time == kNever) continue;
      const double w = 4.0 / (4 + x * x + y * y);
      n += w;
      sx += w * x;
      sy += w * y;
      st += w * time;
      sxx += w * x * x;
      sxy += w * x * y;
      syy += w * y * y;
      sxt += w * x * time;
      syt += w * y * time;
    }
  }
  const double cxx = sxx - sx * sx / n;
  const double cxy = sxy - sx * sy / n;
  const double cyy = syy - sy * sy / n;
  const double cxt = sxt - sx * st / n;
  const double cyt = syt - sy * st / n;
  TimePlane plane;
  ASSERT_TRUE(Window(time_of).fit(plane, 8));
  EXPECT_NEAR(plane.b, (cyt * cxx - cxt * cxy) / (cxx * cyy - cxy * cxy), 1e-9);
}

TEST(TrimmedPlaneFit, TheLongestWindowDoesNotOverflow) {
  constexpr Time kWindow = asap::PlaneFit::kMaxWindow_us;
  const Window window([](int x, int) { return x == 3 ? 0 : (x - 3) * (kWindow / 6); });
  TimePlane plane;
  ASSERT_TRUE(window.fit(plane, 7, kWindow));
  EXPECT_NEAR(plane.a, kWindow / 6, 1e-3);
}

}  // namespace
}  // namespace trimmed_plane_fit_test
