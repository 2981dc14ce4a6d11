#include "algorithms/cell_grid.hpp"

#include <algorithm>
#include <cmath>

namespace asap {
namespace {

constexpr int kMinSide = 8;            // px: smaller cells cost memory and gain nothing
constexpr int kMaxCellsPerAxis = 200;  // border excluded: all cell numbers fit 16 bits

// A point within the radius, rounded to a pixel, is at most floor(radius) + 1 pixels away.
int choose_side(int width, int height, double radius) {
  const int longest = std::max(width, height);
  const int reach = radius < longest ? static_cast<int>(std::floor(radius)) + 1 : longest;
  const int finest = (longest + kMaxCellsPerAxis - 1) / kMaxCellsPerAxis;
  return std::max({reach, finest, kMinSide});
}

}  // namespace

CellGrid::CellGrid(int width, int height, double radius)
    : side_(choose_side(width, height, radius)),
      stride_(static_cast<std::size_t>((width - 1) / side_ + 3)),
      size_(stride_ * static_cast<std::size_t>((height - 1) / side_ + 3)),
      column_(static_cast<std::size_t>(width)),
      row_(static_cast<std::size_t>(height)) {
  const auto side = static_cast<std::size_t>(side_);
  for (std::size_t x = 0; x < column_.size(); ++x) column_[x] = static_cast<Cell>(x / side + 1);
  for (std::size_t y = 0; y < row_.size(); ++y) {
    row_[y] = static_cast<Cell>((y / side + 1) * stride_);
  }
}

}  // namespace asap
