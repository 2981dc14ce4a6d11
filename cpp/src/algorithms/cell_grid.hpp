// CellGrid: the frame cut into square cells, with a border of empty cells so that the 3 x 3 block
// around any cell exists. The side is chosen so that the block around a pixel holds every pixel
// within the L1 radius, and every point within it that is rounded to a pixel. O(1) by table
// look-up; allocates in the constructor only. Geometry alone: what stands in a cell is kept by
// others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap {

class CellGrid {
 public:
  using Cell = std::uint16_t;

  CellGrid(int width, int height, double radius);

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
  int side_;
  std::size_t stride_;
  std::size_t size_;
  std::vector<Cell> column_;
  std::vector<Cell> row_;
};

}  // namespace asap
