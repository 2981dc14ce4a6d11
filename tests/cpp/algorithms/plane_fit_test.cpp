#include "algorithms/plane_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

namespace plane_fit_test {
namespace {

using asap::PlaneFit;
using asap::TimePlane;
using Time = PlaneFit::Time;

constexpr Time kNever = asap::RecentTimes::kLongAgo;
constexpr std::ptrdiff_t kStride = 9;

// A window whose pixels fired at time_of(x, y), around the centre; room for the lanes read beyond.
class Window {
 public:
  explicit Window(const std::function<Time(int, int)>& time_of) : times_(64, 77) {
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) centre()[y * kStride + x] = time_of(x, y);
    }
  }

  PlaneFit fit(Time window_us) { return PlaneFit(centre(), kStride, window_us); }

 private:
  Time* centre() { return times_.data() + 2 * kStride + 2; }

  std::vector<Time> times_;
};

TEST(PlaneFit, FindsThePlaneOfAnEdge) {
  Window window([](int x, int y) { return 1000 + 30 * x - 40 * y; });
  PlaneFit fit = window.fit(2000);
  EXPECT_EQ(fit.points(), 25);
  TimePlane plane;
  ASSERT_TRUE(fit.fit(plane));
  EXPECT_EQ(plane.a, 30);
  EXPECT_EQ(plane.b, -40);
  EXPECT_EQ(plane.c, 0);
  EXPECT_EQ(fit.drop_outliers(plane), 0);
}

TEST(PlaneFit, FitsTheRecentPixelsOnly) {
  // Two rows are as old as the window, one never fired.
  Window window([](int, int y) { return y == 2 ? kNever : (y < 0 ? 9'100 : 10'000); });
  EXPECT_EQ(window.fit(899).points(), 10);
  EXPECT_EQ(window.fit(900).points(), 20);
  EXPECT_EQ(window.fit(PlaneFit::kMaxWindow_us).points(), 20);
}

TEST(PlaneFit, PointsOnALineHaveNoPlane) {
  TimePlane plane;
  EXPECT_FALSE(Window([](int x, int y) { return x == y ? 10 * x : kNever; }).fit(90).fit(plane));
  EXPECT_FALSE(Window([](int x, int) { return x == 0 ? 0 : kNever; }).fit(90).fit(plane));
  EXPECT_TRUE(
      Window([](int x, int y) { return x == 0 || y == 2 ? 5 * y : kNever; }).fit(90).fit(plane));
}

TEST(PlaneFit, DropsWhatLiesFarFromThePlane) {
  const auto time_of = [](int x, int y) { return x == 1 && y == -2 ? -5000 : 20 * x; };
  PlaneFit fit = Window(time_of).fit(9000);
  TimePlane plane;
  ASSERT_TRUE(fit.fit(plane));
  EXPECT_GT(std::abs(plane.b), 1);
  EXPECT_EQ(fit.drop_outliers(plane), 1);
  EXPECT_EQ(fit.points(), 24);
  ASSERT_TRUE(fit.fit(plane));
  EXPECT_DOUBLE_EQ(plane.a, 20);
  EXPECT_NEAR(plane.b, 0, 1e-12);
  EXPECT_EQ(fit.drop_outliers(plane), 0);
}

TEST(PlaneFit, AMicrosecondIsNoOutlier) {
  PlaneFit fit = Window([](int x, int y) { return 20 * x + (x == 2 && y == 2); }).fit(9000);
  TimePlane plane;
  ASSERT_TRUE(fit.fit(plane));
  EXPECT_EQ(fit.drop_outliers(plane), 0);
}

TEST(PlaneFit, TheLongestWindowDoesNotOverflow) {
  constexpr Time kWindow = PlaneFit::kMaxWindow_us;
  PlaneFit fit = Window([](int x, int y) { return x == 0 && y == 0 ? 0 : -kWindow; }).fit(kWindow);
  EXPECT_EQ(fit.points(), 25);
  TimePlane plane;
  ASSERT_TRUE(fit.fit(plane));
  EXPECT_EQ(plane.a, 0);
  EXPECT_EQ(plane.c, -0.96 * kWindow);
}

}  // namespace
}  // namespace plane_fit_test
