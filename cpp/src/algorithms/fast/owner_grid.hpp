// OwnerGrid: the frame in small square cells, each of which remembers which cluster last took an
// event there, when, and of which polarity. An entry is valid while the cluster's slot still has
// the generation that is noted and the note is young, so that all cells of a deleted cluster go
// stale at once. A border of one cell lies around the frame. One thread. O(1), allocates in the
// constructor only.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/fast/stamp.hpp"

namespace asap::fast {

// Where cells lie; the same for the grid of owners and that of orphans.
class CellMap {
 public:
  CellMap(int width, int height, int side) noexcept
      : shift_(std::countr_zero(static_cast<unsigned>(side))),
        stride_((static_cast<std::size_t>(width - 1) >> shift_) + 3),
        rows_((static_cast<std::size_t>(height - 1) >> shift_) + 3) {}

  std::size_t size() const noexcept { return stride_ * rows_; }
  std::size_t stride() const noexcept { return stride_; }
  std::size_t rows() const noexcept { return rows_; }

  // Precondition: the pixel lies in the frame.
  std::size_t cell(std::size_t x, std::size_t y) const noexcept {
    return ((y >> shift_) + 1) * stride_ + (x >> shift_) + 1;
  }

  // Cells of the frame, at most `half` columns and rows from the one that is nearest to a position.
  struct Window {
    int left = 0;
    int top = 0;
    int columns = 0;
    int rows = 0;
  };
  Window window(float x, float y, int half) const noexcept {
    const int column = nearest_column(x);
    const int row = nearest_row(y);
    const int left = std::max(1, column - half);
    const int top = std::max(1, row - half);
    return {left, top, std::min(static_cast<int>(stride_) - 2, column + half) - left + 1,
            std::min(static_cast<int>(rows_) - 2, row + half) - top + 1};
  }

  // Column or row of the cell that holds a position or, if it is outside, is nearest to it.
  int nearest_column(float x) const noexcept { return nearest(x, stride_); }
  int nearest_row(float y) const noexcept { return nearest(y, rows_); }

  // px, the middle of a column or row.
  float centre(std::size_t index) const noexcept {
    const auto side = static_cast<float>(1 << shift_);
    return (static_cast<float>(index) - 1) * side + (side - 1) / 2;
  }

  int cells_in(float px) const noexcept { return static_cast<int>(px) >> shift_; }

  // Calls visit(cell) for the eight cells around one that is no border cell.
  template <class Visit>
  void for_each_neighbour(std::size_t cell, Visit&& visit) const noexcept {
    for (const std::size_t row : {cell - stride_, cell + stride_}) {
      visit(row - 1);
      visit(row);
      visit(row + 1);
    }
    visit(cell - 1);
    visit(cell + 1);
  }

 private:
  int nearest(float position, std::size_t cells) const noexcept {
    const auto last = static_cast<float>(cells - 2);
    const float index = position / static_cast<float>(1 << shift_) + 1;
    return static_cast<int>(std::clamp(index, 1.0F, last));
  }

  int shift_;
  std::size_t stride_;
  std::size_t rows_;
};

class OwnerGrid {
 public:
  struct Cell {
    Stamp stamp;
    std::uint16_t generation;
    std::uint8_t slot;     // there are 256 at most
    std::int8_t sign = 0;  // ON = 1, OFF = -1
  };

  explicit OwnerGrid(const CellMap& map) : cells_(map.size()), scrubber_(map.size()) {}

  void clear(Stamp now) noexcept {
    std::fill(cells_.begin(), cells_.end(), Cell{long_before(now), 0, 0, 0});
  }

  Cell& operator[](std::size_t cell) noexcept { return cells_[cell]; }
  const Cell& operator[](std::size_t cell) const noexcept { return cells_[cell]; }

  void give(std::span<const std::size_t> cells, std::size_t slot,
            std::uint16_t generation) noexcept {
    for (const std::size_t cell : cells) {
      cells_[cell].slot = static_cast<std::uint8_t>(slot);
      cells_[cell].generation = generation;
    }
  }

  void scrub(Stamp now, std::uint64_t elapsed_us) noexcept {
    scrubber_.advance(elapsed_us, [&](std::size_t first, std::size_t count) {
      fast::scrub(cells_.data() + first, count, now,
                  [](Cell& cell) -> Stamp& { return cell.stamp; });
    });
  }

 private:
  std::vector<Cell> cells_;
  Scrubber scrubber_;
};

}  // namespace asap::fast
