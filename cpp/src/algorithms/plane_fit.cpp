#include "algorithms/plane_fit.hpp"

#include <algorithm>
#include <numeric>

namespace asap::inline v0_1 {
namespace {

constexpr std::size_t kSide = PlaneFit::kSide;
constexpr std::size_t kLanes = PlaneFit::kLanes;
using Row = std::array<std::int32_t, kLanes>;

std::int32_t from_centre(std::size_t index) noexcept {
  return static_cast<std::int32_t>(index) - static_cast<std::int32_t>(PlaneFit::kReach);
}

template <class Sum>
struct Moments {
  Sum zeroth;
  Sum first;
  Sum second;
};

// The moments of five values at -2 .. 2.
template <class Sum>
Moments<Sum> moments(Sum v0, Sum v1, Sum v2, Sum v3, Sum v4) noexcept {
  const Sum far = v0 + v4;
  const Sum near = v1 + v3;
  return {.zeroth = far + near + v2, .first = 2 * (v4 - v0) + v3 - v1, .second = 4 * far + near};
}

Moments<std::int64_t> along_x(const Row& columns) noexcept {
  return moments<std::int64_t>(columns[0], columns[1], columns[2], columns[3], columns[4]);
}

Moments<Row> along_y(const std::array<Row, kSide>& rows) noexcept {
  Moments<Row> columns;
  for (std::size_t x = 0; x < kLanes; ++x) {
    const auto [zeroth, first, second] =
        moments(rows[0][x], rows[1][x], rows[2][x], rows[3][x], rows[4][x]);
    columns.zeroth[x] = zeroth;
    columns.first[x] = first;
    columns.second[x] = second;
  }
  return columns;
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
  Row columns{};
  for (const Row& row : used_) {
    for (std::size_t x = 0; x < kLanes; ++x) columns[x] += row[x];
  }
  return std::accumulate(columns.begin(), columns.begin() + kSide, 0);
}

bool PlaneFit::fit(TimePlane& plane) const noexcept {
  const Moments<Row> of_used = along_y(used_);
  const Moments<Row> of_times = along_y(times_);
  const auto [n, sx, sxx] = along_x(of_used.zeroth);
  const auto [sy, sxy, sxxy] = along_x(of_used.first);
  const auto [st, sxt, sxxt] = along_x(of_times.zeroth);
  const std::int64_t syy = along_x(of_used.second).zeroth;
  const std::int64_t syt = along_x(of_times.first).zeroth;

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
  constexpr double kMin_us2 = 1.0;
  constexpr double kFactor = 4.0;  // factor on squares
  std::array<std::array<double, kLanes>, kSide> squares;
  std::array<double, kLanes> sums{};
  std::array<double, kLanes> of_columns;
  for (std::size_t x = 0; x < kLanes; ++x) of_columns[x] = plane.a * from_centre(x);
  for (std::size_t y = 0; y < kSide; ++y) {
    const double of_row = plane.b * from_centre(y) + plane.c;
    for (std::size_t x = 0; x < kLanes; ++x) {
      const double distance = times_[y][x] - (of_columns[x] + of_row);
      const double square = distance * distance * used_[y][x];
      squares[y][x] = square;
      sums[x] += square;
    }
  }
  const double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  const double limit = std::max(kMin_us2, kFactor * sum / points());
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

}  // namespace asap::inline v0_1
