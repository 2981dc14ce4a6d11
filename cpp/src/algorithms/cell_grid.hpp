// CellGrid: the frame cut into square cells, with a border of empty cells so that the 3 x 3 block
// around any cell exists. The side is chosen so that the block around a pixel holds every pixel
// within the L1 radius, and every point within it that is rounded to a pixel. O(1) by table
// look-up; allocates in the constructor only. Geometry alone: what stands in a cell is kept by
// others.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap::inline v0_1 {

class CellGrid {
 public:
  using Cell = std::uint16_t;

  CellGrid(int width, int height, double radius)
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

  // Number of cells, border included.
  std::size_t size() const noexcept { return size_; }
  int side() const noexcept { return side_; }

  // Precondition: the pixel lies in the frame.
  Cell cell(std::size_t x, std::size_t y) const noexcept {
    return static_cast<Cell>(row_[y] + column_[x]);
  }

  // Calls visit(cell) for the 3 x 3 cells around `centre`, which is no border cell.
  template <class Visit>
  void for_each_around(Cell centre, Visit&& visit) const noexcept {
    for (std::size_t row = centre - stride_; row <= centre + stride_; row += stride_) {
      visit(row - 1);
      visit(row);
      visit(row + 1);
    }
  }

 private:
  static constexpr int kMinSide = 8;            // px: smaller cells cost memory and gain nothing
  static constexpr int kMaxCellsPerAxis = 200;  // border excluded: all cell numbers fit 16 bits

  // A point within the radius, rounded to a pixel, is at most floor(radius) + 1 pixels away.
  static int choose_side(int width, int height, double radius) {
    const int longest = std::max(width, height);
    const int reach = radius < longest ? static_cast<int>(std::floor(radius)) + 1 : longest;
    const int finest = (longest + kMaxCellsPerAxis - 1) / kMaxCellsPerAxis;
    return std::max({reach, finest, kMinSide});
  }

  int side_;
  std::size_t stride_;
  std::size_t size_;
  std::vector<Cell> column_;
  std::vector<Cell> row_;
};

}  // namespace asap::inline v0_1
