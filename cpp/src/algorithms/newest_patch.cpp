#include "algorithms/newest_patch.hpp"

#include <cstddef>
#include <cstdint>

#include "algorithms/int4.hpp"

namespace asap::inline v0_1 {
namespace {

using Number = OrderSurface::Number;
constexpr std::ptrdiff_t kReach = 4;
constexpr int kOthers = NewestPatch::kPixels - 1;  // the centre is one of them in any case

// The window without its centre, four numbers at a time: the first eight columns row by row, then
// the ninth. Row 4 has its eight pixels beside the centre. (The centre was written just now: a load
// across it would wait for the store.)
class Window {
 public:
  Window(const Number* centre, std::ptrdiff_t stride) noexcept {
    const Number* row = centre - kReach * stride - kReach;
    Number ninth[kSide];
    for (std::size_t y = 0; y < kSide; ++y, row += stride) {
      parts_[2 * y] = Int4::load(row);
      parts_[2 * y + 1] = Int4::load(y == kReach ? row + 5 : row + 4);
      ninth[y] = row[8];
    }
    parts_[18] = Int4::of(ninth[0], ninth[1], ninth[2], ninth[3]);
    parts_[19] = Int4::of(ninth[5], ninth[6], ninth[7], ninth[8]);
  }

  // Numbers that reach the bar. Two sums, so that they do not wait for each other.
  int count(Number bar) const noexcept {
    Int4::Lanes counts[2]{Int4::zero(), Int4::zero()};
    for (std::size_t i = 0; i < 20; i += 2) {
      for (std::size_t j = 0; j < 2; ++j) {
        counts[j] = Int4::count_above(counts[j], parts_[i + j], bar - 1);
      }
    }
    return Int4::sum(Int4::add(counts[0], counts[1]));
  }

  void rows(Number bar, PatchRows& rows) const noexcept {
    const auto mask = [&](std::size_t part) { return Int4::mask_above(parts_[part], bar - 1); };
    const std::uint32_t ninth = mask(18) | mask(19) << 5;
    for (std::size_t y = 0; y < kSide; ++y) {
      rows[y] = mask(2 * y) | mask(2 * y + 1) << 4 | ((ninth >> y) & 1) << 8;
    }
    rows[kReach] = mask(2 * kReach) | 1U << 4 | mask(2 * kReach + 1) << 5;
  }

 private:
  static constexpr std::size_t kSide = 9;

  Int4::Lanes parts_[20];
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
  while (above < kOthers) {
    if (bar == kLowest) return false;
    high = bar;
    const Number depth = newest - bar;
    bar = depth < bar - kLowest ? bar - depth : kLowest;
    above = window.count(bar);
  }
  // More than 24 others reach `low`, fewer reach `high`.
  for (Number low = bar; above != kOthers;) {
    bar = low + (high - low) / 2;
    above = window.count(bar);
    high = above < kOthers ? bar : high;
    low = above < kOthers ? low : bar;
  }
  depth_ = newest - bar;
  window.rows(bar, rows);
  return true;
}

}  // namespace asap::inline v0_1
