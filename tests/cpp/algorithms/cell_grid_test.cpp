#include "algorithms/cell_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <vector>

namespace cell_grid_test {
namespace {

using asap::CellGrid;

std::set<std::size_t> around(const CellGrid& grid, CellGrid::Cell cell) {
  std::set<std::size_t> cells;
  grid.for_each_around(cell, [&](std::size_t c) { cells.insert(c); });
  return cells;
}

TEST(CellGrid, BlockHoldsEveryPixelWithinTheRadius) {
  constexpr int kWidth = 61;
  constexpr int kHeight = 47;
  for (const double radius : {0.0, 7.0, 7.5, 8.0, 12.5, 20.0, 500.0}) {
    const CellGrid grid(kWidth, kHeight, radius);
    for (int x = 0; x < kWidth; x += 3) {
      for (int y = 0; y < kHeight; y += 3) {
        const auto block =
            around(grid, grid.cell(static_cast<std::size_t>(x), static_cast<std::size_t>(y)));
        // A centre within the radius, rounded, may lie half a pixel farther.
        const int reach = static_cast<int>(std::min(radius + 0.5, 100.0));
        for (int u = std::max(0, x - reach); u < std::min(kWidth, x + reach + 1); ++u) {
          for (int v = std::max(0, y - reach); v < std::min(kHeight, y + reach + 1); ++v) {
            ASSERT_TRUE(
                block.contains(grid.cell(static_cast<std::size_t>(u), static_cast<std::size_t>(v))))
                << "radius " << radius << ", " << x << "," << y << " to " << u << "," << v;
          }
        }
      }
    }
  }
}

TEST(CellGrid, BlockIsNineCellsInsideTheGrid) {
  const CellGrid grid(346, 260, 20);
  for (const std::size_t x : {0U, 100U, 345U}) {
    for (const std::size_t y : {0U, 100U, 259U}) {
      const auto block = around(grid, grid.cell(x, y));
      EXPECT_EQ(block.size(), 9U);
      EXPECT_LT(*block.rbegin(), grid.size());
    }
  }
}

TEST(CellGrid, SideFollowsTheRadius) {
  EXPECT_EQ(CellGrid(346, 260, 20).side(), 21);
  EXPECT_EQ(CellGrid(346, 260, 20.9).side(), 21);
  EXPECT_EQ(CellGrid(346, 260, 1e300).side(), 346);
}

TEST(CellGrid, SmallRadiiDoNotMultiplyTheCells) {
  EXPECT_EQ(CellGrid(346, 260, 0).side(), 8);
  EXPECT_LE(CellGrid(65536, 65536, 0).size(), 65536U);
}

TEST(CellGrid, LargestFrameHasDistinctCells) {
  const CellGrid grid(65536, 65536, 0);
  const auto step = static_cast<std::size_t>(grid.side());
  std::set<std::size_t> cells;
  std::size_t expected = 0;
  for (std::size_t x = 0; x < 65536; x += step) {
    for (std::size_t y = 0; y < 65536; y += step) {
      cells.insert(grid.cell(x, y));
      ++expected;
    }
  }
  EXPECT_EQ(cells.size(), expected);
}

}  // namespace
}  // namespace cell_grid_test
