#include "algorithms/fast/owner_grid.hpp"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace owner_grid_test {
namespace {

using asap::fast::CellMap;
using asap::fast::long_before;
using asap::fast::OwnerGrid;

TEST(CellMap, EveryPixelHasACellWithEightNeighbours) {
  for (const int side : {1, 4, 64}) {
    const CellMap map(33, 18, side);
    std::set<std::size_t> cells;
    for (std::size_t y = 0; y < 18; ++y) {
      for (std::size_t x = 0; x < 33; ++x) {
        const std::size_t cell = map.cell(x, y);
        cells.insert(cell);
        std::set<std::size_t> neighbours;
        map.for_each_neighbour(cell, [&](std::size_t n) {
          ASSERT_LT(n, map.size());
          ASSERT_NE(n, cell);
          neighbours.insert(n);
        });
        ASSERT_EQ(neighbours.size(), 8U);
      }
    }
    const auto across = [&](int length) {
      return static_cast<std::size_t>((length - 1) / side + 1);
    };
    EXPECT_EQ(cells.size(), across(33) * across(18)) << side;
  }
}

TEST(CellMap, ColumnsAndPositionsAgree) {
  const CellMap map(40, 20, 4);
  for (std::size_t x = 0; x < 40; ++x) {
    const auto column = static_cast<std::size_t>(map.nearest_column(static_cast<float>(x)));
    EXPECT_EQ(map.cell(x, 0) % map.stride(), column);
    EXPECT_NEAR(map.centre(column), static_cast<float>(x), 1.5F);
  }
  EXPECT_EQ(map.nearest_column(-1e9F), 1);
  EXPECT_EQ(map.nearest_column(1e9F), 10);
  EXPECT_EQ(map.nearest_row(1e9F), 5);
  EXPECT_EQ(map.cells_in(11), 2);
}

TEST(CellMap, AWindowStaysInTheFrame) {
  const CellMap map(40, 20, 4);  // 10 x 5 cells
  const auto inner = map.window(17, 9, 1);
  EXPECT_EQ(inner.left, 4);
  EXPECT_EQ(inner.top, 2);
  EXPECT_EQ(inner.columns, 3);
  EXPECT_EQ(inner.rows, 3);
  const auto outer = map.window(-30, 60, 2);
  EXPECT_EQ(outer.left, 1);
  EXPECT_EQ(outer.columns, 3);
  EXPECT_EQ(outer.top, 3);
  EXPECT_EQ(outer.rows, 3);
}

TEST(OwnerGrid, GivesCellsAway) {
  const CellMap map(8, 8, 4);
  OwnerGrid grid(map);
  const std::array cells{map.cell(3, 3), map.cell(7, 3)};
  grid[cells[0]] = {77, 2, 1, -1};
  grid.give(cells, 255, 9);
  EXPECT_EQ(grid[cells[0]].slot, 255);
  EXPECT_EQ(grid[cells[1]].generation, 9);
  EXPECT_EQ(grid[cells[0]].stamp, 77U);
  EXPECT_EQ(grid[cells[0]].sign, -1);
}

TEST(OwnerGrid, BeginsWithStaleCellsAndScrubsOldOnes) {
  const CellMap map(8, 8, 4);
  OwnerGrid grid(map);
  grid.clear(77);
  EXPECT_EQ(grid[map.cell(3, 3)].stamp, long_before(77));
  grid[map.cell(3, 3)] = {77, 2, 1};
  const asap::fast::Stamp later = 77 + 1'200'000'000U;
  grid.scrub(later, asap::fast::Scrubber::kRound_us);
  EXPECT_EQ(grid[map.cell(3, 3)].stamp, long_before(later));
}

}  // namespace
}  // namespace owner_grid_test
