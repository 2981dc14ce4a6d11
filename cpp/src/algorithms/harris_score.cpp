#include "algorithms/harris_score.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

// Five columns of gradients, so placed that columns of equal weight stand four lanes apart: 2, 1, 0
// and 3, 4. The other lanes are zeros.
constexpr std::size_t kHarrisLanes = 8;
constexpr std::size_t kHarrisSide = 5;
typedef std::int16_t Columns __attribute__((vector_size(2 * kHarrisLanes)));
typedef std::int64_t Halves __attribute__((vector_size(2 * kHarrisLanes)));
constexpr std::array<std::size_t, kHarrisSide> kLaneOf{2, 1, 0, 5, 6};

constexpr std::array<int, kHarrisSide> kSmooth{1, 4, 6, 4, 1};
constexpr std::array<int, kHarrisSide> kDerive{1, 2, 0, -2, -1};
constexpr double kScale = 12;  // scale of the kernel

// One row of pixels folded with a kernel, for each of the 512 rows there are.
struct alignas(16) Folded {
  std::array<std::int16_t, kHarrisLanes> columns;
};

constexpr std::array<Folded, 512> fold(const std::array<int, kHarrisSide>& kernel) {
  std::array<Folded, 512> table{};
  for (std::size_t row = 0; row < table.size(); ++row) {
    for (std::size_t column = 0; column < kHarrisSide; ++column) {
      int sum = 0;
      for (std::size_t k = 0; k < kHarrisSide; ++k) {
        if ((row >> (column + k)) & 1) sum += kernel[k];
      }
      table[row].columns[kLaneOf[column]] = static_cast<std::int16_t>(sum);
    }
  }
  return table;
}

constexpr auto kSmoothed = fold(kSmooth);
constexpr auto kDerived = fold(kDerive);

Columns look_up(const std::array<Folded, 512>& table, std::uint32_t row) noexcept {
  Columns columns;
  std::memcpy(&columns, &table[row], sizeof(columns));
  return columns;
}

// Weights of the window: exp(-(i^2 + j^2) / 2), i and j from -2 to 2, here per axis and before they
// are normalised.
constexpr double kNear = 0.60653065971263342;  // exp(-1/2)
constexpr double kFar = 0.13533528323661269;   // exp(-2)
constexpr double kAxis = 1 + 2 * (kNear + kFar);
constexpr double kUnit = 1 / (kAxis * kAxis * kScale * kScale);

// Lanes 0 to 2: the sums of the columns at distance 0 to 2 from the middle one.
Columns folded(Columns columns) noexcept {
  const Halves halves = reinterpret_cast<Halves>(columns);
  return columns + reinterpret_cast<Columns>(Halves{halves[1], halves[0]});
}

// What has the same weight is added up in integers first.
double weighted(const std::array<Columns, kHarrisSide>& rows) noexcept {
  const Columns middle = folded(rows[2]);
  const Columns inner = folded(rows[1] + rows[3]);
  const Columns outer = folded(rows[0] + rows[4]);
  return kUnit *
         (middle[0] + kNear * (middle[1] + inner[0]) + kFar * (middle[2] + outer[0]) +
          kNear * kNear * inner[1] + kNear * kFar * (inner[2] + outer[1]) + kFar * kFar * outer[2]);
}

}  // namespace

double checked_threshold(double threshold) {
  require(std::isfinite(threshold), "threshold", threshold, "must be finite");
  return threshold;
}

double harris_score(const PatchRows& rows) noexcept {
  std::array<Columns, 9> smoothed;
  std::array<Columns, 9> derived;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    smoothed[y] = look_up(kSmoothed, rows[y]);
    derived[y] = look_up(kDerived, rows[y]);
  }
  std::array<Columns, kHarrisSide> xx;
  std::array<Columns, kHarrisSide> xy;
  std::array<Columns, kHarrisSide> yy;
  for (std::size_t y = 0; y < kHarrisSide; ++y) {
    const Columns gx =
        derived[y] + derived[y + 4] + 4 * (derived[y + 1] + derived[y + 3]) + 6 * derived[y + 2];
    const Columns gy = smoothed[y] - smoothed[y + 4] + 2 * (smoothed[y + 1] - smoothed[y + 3]);
    xx[y] = gx * gx;
    xy[y] = gx * gy;
    yy[y] = gy * gy;
  }
  const double a = weighted(xx);
  const double b = weighted(xy);
  const double d = weighted(yy);
  return a * d - b * b - 0.04 * (a + d) * (a + d);
}

}  // namespace asap::inline v0_1
