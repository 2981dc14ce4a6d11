#include "asap/algorithms/plane_fit.hpp"

#include <algorithm>
#include <numeric>

namespace asap {
namespace {

constexpr std::size_t kSide = PlaneFit::kSide;
constexpr std::size_t kLanes = PlaneFit::kLanes;
using Row = std::array<std::int32_t, kLanes>;

std::int32_t from_centre(std::size_t index) noexcept {
  return static_cast<std::int32_t>(index) - static_cast<std::int32_t>(PlaneFit::kReach);
}

struct Moments {
  std::int64_t zeroth = 0;
  std::int64_t first = 0;
  std::int64_t second = 0;
};

// Of a row of column sums, along x.
Moments moments(const Row& columns) noexcept {
  const std::int64_t far = columns[0] + columns[4];
  const std::int64_t near = columns[1] + columns[3];
  return {.zeroth = far + near + columns[2],
          .first = 2 * std::int64_t{columns[4] - columns[0]} + columns[3] - columns[1],
          .second = 4 * far + near};
}

}  // namespace

PlaneFit::PlaneFit(const Time* centre, std::ptrdiff_t stride, Time window_us) noexcept {
  const Time now = *centre;
  const Time oldest = now - window_us;
  const Time* row = centre - kReach * stride - kReach;
  for (std::size_t y = 0; y < kSide; ++y, row += stride) {
    for (std::size_t x = 0; x < kLanes; ++x) {
      const bool used = x < kSide && row[x] >= oldest;
      used_[y][x] = used;
      times_[y][x] = used ? row[x] - now : 0;
    }
  }
}

int PlaneFit::points() const noexcept {
  int points = 0;
  for (const Row& row : used_) {
    for (std::size_t x = 0; x < kSide; ++x) points += row[x];
  }
  return points;
}

bool PlaneFit::fit(TimePlane& plane) const noexcept {
  Row count{};  // column sums: of 1, y, y^2, t, y t
  Row sum_y{};
  Row sum_yy{};
  Row sum_t{};
  Row sum_yt{};
  for (std::size_t row = 0; row < kSide; ++row) {
    const std::int32_t y = from_centre(row);
    for (std::size_t x = 0; x < kLanes; ++x) {
      count[x] += used_[row][x];
      sum_y[x] += y * used_[row][x];
      sum_yy[x] += y * y * used_[row][x];
      sum_t[x] += times_[row][x];
      sum_yt[x] += y * times_[row][x];
    }
  }
  const auto [n, sx, sxx] = moments(count);
  const auto [sy, sxy, unused_y] = moments(sum_y);
  const auto [st, sxt, unused_t] = moments(sum_t);
  const std::int64_t syy = moments(sum_yy).zeroth;
  const std::int64_t syt = moments(sum_yt).zeroth;

  // n times the sums without their means.
  const std::int64_t cxx = n * sxx - sx * sx;
  const std::int64_t cxy = n * sxy - sx * sy;
  const std::int64_t cyy = n * syy - sy * sy;
  const std::int64_t cxt = n * sxt - sx * st;
  const std::int64_t cyt = n * syt - sy * st;
  const std::int64_t determinant = cxx * cyy - cxy * cxy;
  if (determinant <= 0) return false;
  const auto scale = static_cast<double>(determinant);
  plane.a = static_cast<double>(cxt * cyy - cyt * cxy) / scale;
  plane.b = static_cast<double>(cyt * cxx - cxt * cxy) / scale;
  plane.c = (static_cast<double>(st) - plane.a * static_cast<double>(sx) -
             plane.b * static_cast<double>(sy)) /
            static_cast<double>(n);
  return true;
}

int PlaneFit::drop_outliers(const TimePlane& plane) noexcept {
  constexpr double kLeast_us2 = 1.0;
  constexpr double kFactor = 4.0;  // of squares
  std::array<std::array<double, kLanes>, kSide> squares;
  std::array<double, kLanes> sums{};
  for (std::size_t y = 0; y < kSide; ++y) {
    const double of_row = plane.b * from_centre(y) + plane.c;
    for (std::size_t x = 0; x < kLanes; ++x) {
      const double distance = times_[y][x] - (plane.a * from_centre(x) + of_row);
      squares[y][x] = used_[y][x] * distance * distance;
      sums[x] += squares[y][x];
    }
  }
  const double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  const double limit = std::max(kLeast_us2, kFactor * sum / points());
  int dropped = 0;
  for (std::size_t y = 0; y < kSide; ++y) {
    for (std::size_t x = 0; x < kLanes; ++x) {
      const bool stays = squares[y][x] <= limit;
      dropped += !stays;
      used_[y][x] = stays ? used_[y][x] : 0;
      times_[y][x] = stays ? times_[y][x] : 0;
    }
  }
  return dropped;
}

}  // namespace asap
