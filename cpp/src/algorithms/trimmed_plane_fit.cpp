#include "algorithms/trimmed_plane_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace asap::inline v0_1 {

// What a pixel of the window adds to the normal equations of a plane.
struct WindowPixel {
  double x;  // px, from the centre
  double y;
  double weight;
  std::array<double, 9> normal;  // weight (x, y, 1) (x, y, 1)^T
  std::array<double, 3> right;   // weight (x, y, 1), for each us of its time
};

namespace {

constexpr int kTrims = 2;
constexpr std::size_t kWindowSide = TrimmedPlaneFit::kSide;

// The edge is straight and alone near the event, less so farther away.
constexpr WindowPixel window_pixel(double x, double y) {
  constexpr double kHalf_px2 = 4.0;
  const double w = kHalf_px2 / (kHalf_px2 + x * x + y * y);
  return {.x = x,
          .y = y,
          .weight = w,
          .normal = {w * x * x, w * x * y, w * x, w * x * y, w * y * y, w * y, w * x, w * y, w},
          .right = {w * x, w * y, w}};
}

constexpr std::array<WindowPixel, kWindowSide * kWindowSide> kWindow = [] {
  std::array<WindowPixel, kWindowSide * kWindowSide> pixels{};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = window_pixel(static_cast<double>(i % kWindowSide) - TrimmedPlaneFit::kReach,
                             static_cast<double>(i / kWindowSide) - TrimmedPlaneFit::kReach);
  }
  return pixels;
}();

}  // namespace

TrimmedPlaneFit::TrimmedPlaneFit(const Time* centre, std::ptrdiff_t stride,
                                 Time window_us) noexcept {
  const Time now = *centre;
  const Time oldest = now - window_us;
  const Time* row = centre - kReach * stride - kReach;
  const WindowPixel* pixel = kWindow.data();
  for (std::size_t y = 0; y < kSide; ++y, row += stride) {
    for (std::size_t x = 0; x < kSide; ++x, ++pixel) {
      const bool used = row[x] >= oldest;
      points_[size_].pixel = pixel;
      points_[size_].t = used ? row[x] - now : 0;
      size_ += used;  // no branch: which pixels are recent is hard to foresee
    }
  }
}

bool TrimmedPlaneFit::fit(std::size_t min_points, TimePlane& plane) noexcept {
  if (size_ < min_points) return false;
  for (const Point& point : points()) add(point, 1);
  double square = 0;
  for (int trims = 0; trims <= kTrims; ++trims) {
    if (!solve(plane)) return false;
    square = mean_square(plane);
    if (trims == kTrims || !drop_outliers(square)) break;
    if (size_ < min_points) return false;
  }
  constexpr double kScatter_px = 0.7;
  const auto n = static_cast<double>(size_);
  const double squared_slope = plane.a * plane.a + plane.b * plane.b;
  // The plane took three degrees of freedom: that near to three points there is always one.
  return n * square <= (n - 3) * kScatter_px * kScatter_px * squared_slope;
}

void TrimmedPlaneFit::add(const Point& point, double times) noexcept {
  normal_ += times * Eigen::Map<const Eigen::Matrix3d>(point.pixel->normal.data());
  right_ += times * point.t * Eigen::Map<const Eigen::Vector3d>(point.pixel->right.data());
}

bool TrimmedPlaneFit::solve(TimePlane& plane) const noexcept {
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal_);
  constexpr double kOnALine = 1e-6;  // far above rounding, far below what one pixel beside it adds
  if (solver.vectorD().minCoeff() < kOnALine) return false;
  const Eigen::Vector3d solution = solver.solve(right_);
  plane = {.a = solution.x(), .b = solution.y(), .c = solution.z()};
  return true;
}

double TrimmedPlaneFit::mean_square(const TimePlane& plane) noexcept {
  double sum = 0;
  for (Point& point : points()) {
    const WindowPixel& at = *point.pixel;
    const double distance = point.t - (plane.a * at.x + plane.b * at.y + plane.c);
    point.square = distance * distance;
    sum += at.weight * point.square;
  }
  return sum / normal_(2, 2);
}

bool TrimmedPlaneFit::drop_outliers(double mean_square) noexcept {
  constexpr double kMin_us2 = 1.0;
  constexpr double kFactor = 1.5 * 1.5;  // factor on squares
  const double limit = std::max(kMin_us2, kFactor * mean_square);
  std::size_t kept = 0;
  for (const Point& point : points()) {
    if (point.square > limit) {
      add(point, -1);
    } else {
      points_[kept++] = point;
    }
  }
  return std::exchange(size_, kept) != kept;
}

}  // namespace asap::inline v0_1
