#include "asap/algorithms/newest_patch.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

#include "asap/algorithms/int4.hpp"

namespace asap {
namespace {

using Number = OrderSurface::Number;
constexpr std::ptrdiff_t kReach = 4;

// The window four numbers at a time: the first eight columns row by row, then the ninth column.
class Window {
 public:
  Window(const Number* centre, std::ptrdiff_t stride) noexcept {
    const Number* row = centre - kReach * stride - kReach;
    Number ninth[kSide];
    for (std::size_t y = 0; y < kSide; ++y, row += stride) {
      parts_[2 * y] = Int4::load(row);
      parts_[2 * y + 1] = Int4::load(row + 4);
      ninth[y] = row[8];
    }
    parts_[18] = Int4::of(ninth[0], ninth[1], ninth[2], ninth[3]);
    parts_[19] = Int4::of(ninth[4], ninth[5], ninth[6], ninth[7]);
    parts_[20] = Int4::of(ninth[8], kNone, kNone, kNone);
  }

  // Numbers that reach the bar. Three sums, so that they do not wait for each other.
  int count(Number bar) const noexcept {
    Int4::Lanes counts[3]{Int4::zero(), Int4::zero(), Int4::zero()};
    for (std::size_t i = 0; i < 21; i += 3) {
      for (std::size_t j = 0; j < 3; ++j) {
        counts[j] = Int4::count_above(counts[j], parts_[i + j], bar - 1);
      }
    }
    return Int4::sum(Int4::add(Int4::add(counts[0], counts[1]), counts[2]));
  }

  void rows(Number bar, PatchRows& rows) const noexcept {
    const auto mask = [&](std::size_t part) { return Int4::mask_above(parts_[part], bar - 1); };
    const std::uint32_t ninth = mask(18) | mask(19) << 4 | mask(20) << 8;
    for (std::size_t y = 0; y < kSide; ++y) {
      rows[y] = mask(2 * y) | mask(2 * y + 1) << 4 | ((ninth >> y) & 1) << 8;
    }
  }

 private:
  static constexpr std::size_t kSide = 9;
  static constexpr Number kNone = -1;  // reaches no bar

  Int4::Lanes parts_[21];
};

}  // namespace

bool NewestPatch::select(const Number* centre, std::ptrdiff_t stride, PatchRows& rows) noexcept {
  constexpr Number kLowest = OrderSurface::kNever + 1;
  const Window window(centre, stride);
  const Number newest = *centre;

  // Down to a bar that enough numbers reach, by steps as large as the way so far.
  Number high = newest;
  Number bar = newest - depth_ > kLowest ? newest - depth_ : kLowest;
  int above = window.count(bar);
  while (above < kPixels) {
    if (bar == kLowest) return false;
    high = bar;
    const Number depth = newest - bar;
    bar = depth < bar - kLowest ? bar - depth : kLowest;
    above = window.count(bar);
  }
  // More than 25 numbers reach `low`, fewer reach `high`.
  for (Number low = bar; above != kPixels;) {
    bar = low + (high - low) / 2;
    above = window.count(bar);
    high = above < kPixels ? bar : high;
    low = above < kPixels ? low : bar;
  }
  depth_ = newest - bar;
  window.rows(bar, rows);
  return true;
}

}  // namespace asap
