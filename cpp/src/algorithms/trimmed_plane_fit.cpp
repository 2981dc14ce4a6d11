#include "algorithms/trimmed_plane_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace asap {
namespace {

constexpr int kTrims = 2;

// Of each pixel of the window. The edge is straight and alone near the event, less so farther away.
constexpr auto kWeights = [] {
  constexpr std::size_t kSide = TrimmedPlaneFit::kSide;
  constexpr double kHalf_px2 = 4.0;
  std::array<std::array<double, kSide>, kSide> weights{};
  for (std::size_t y = 0; y < kSide; ++y) {
    for (std::size_t x = 0; x < kSide; ++x) {
      const double dx = static_cast<double>(x) - TrimmedPlaneFit::kReach;
      const double dy = static_cast<double>(y) - TrimmedPlaneFit::kReach;
      weights[y][x] = kHalf_px2 / (kHalf_px2 + dx * dx + dy * dy);
    }
  }
  return weights;
}();

}  // namespace

TrimmedPlaneFit::TrimmedPlaneFit(const Time* centre, std::ptrdiff_t stride,
                                 Time window_us) noexcept {
  const Time now = *centre;
  const Time oldest = now - window_us;
  const Time* row = centre - kReach * stride - kReach;
  for (std::size_t y = 0; y < kSide; ++y, row += stride) {
    for (std::size_t x = 0; x < kSide; ++x) {
      const bool used = row[x] >= oldest;
      points_[size_] = {.x = static_cast<double>(x) - kReach,
                        .y = static_cast<double>(y) - kReach,
                        .t = static_cast<double>(used ? row[x] - now : 0),
                        .weight = kWeights[y][x]};
      size_ += used;  // no branch: which pixels are recent is hard to foresee
    }
  }
}

bool TrimmedPlaneFit::fit(std::size_t min_points, TimePlane& plane) noexcept {
  if (size_ < min_points) return false;
  for (const Point& point : points()) add(point, point.weight);
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

void TrimmedPlaneFit::add(const Point& point, double weight) noexcept {
  const Eigen::Vector3d row(point.x, point.y, 1);
  normal_.noalias() += (weight * row) * row.transpose();
  right_.noalias() += (weight * point.t) * row;
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
    const double distance = point.t - (plane.a * point.x + plane.b * point.y + plane.c);
    point.square = distance * distance;
    sum += point.weight * point.square;
  }
  return sum / normal_(2, 2);
}

bool TrimmedPlaneFit::drop_outliers(double mean_square) noexcept {
  constexpr double kLeast_us2 = 1.0;
  constexpr double kFactor = 1.5 * 1.5;  // of squares
  const double limit = std::max(kLeast_us2, kFactor * mean_square);
  std::size_t kept = 0;
  for (const Point& point : points()) {
    if (point.square > limit) {
      add(point, -point.weight);
    } else {
      points_[kept++] = point;
    }
  }
  return std::exchange(size_, kept) != kept;
}

}  // namespace asap
