#include "algorithms/fast/orphan_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orphan_grid_test {
namespace {

using asap::fast::CellMap;
using asap::fast::OrphanGrid;

TEST(OrphanGrid, CountsWithDecay) {
  const CellMap map(40, 40, 4);
  OrphanGrid grid(map, 0.015F);
  grid.clear(0);
  const std::size_t cell = map.cell(20, 20);
  EXPECT_EQ(grid.count(cell, 0), 1);
  EXPECT_EQ(grid.count(cell, 0), 2);
  EXPECT_NEAR(grid.count(cell, 15'000), 1 + 2 * std::exp(-1.0), 1e-4);
}

TEST(OrphanGrid, NeighboursFadeLinearlyInTwoTimeConstants) {
  const CellMap map(40, 40, 4);
  OrphanGrid grid(map, 0.015F);
  grid.clear(0);
  grid.count(map.cell(16, 16), 0);
  EXPECT_NEAR(grid.count(map.cell(20, 20), 15'000), 1 + 0.5, 1e-5);
  EXPECT_NEAR(grid.count(map.cell(12, 12), 30'000), 1, 1e-5);
  EXPECT_NEAR(grid.count(map.cell(36, 36), 15'000), 1, 1e-5);  // no neighbour
}

TEST(OrphanGrid, ForgetsACellAndItsNeighbours) {
  const CellMap map(40, 40, 4);
  OrphanGrid grid(map, 0.015F);
  grid.clear(0);
  grid.count(map.cell(16, 16), 0);
  grid.count(map.cell(20, 20), 0);
  grid.forget(map.cell(20, 20));
  EXPECT_EQ(grid.count(map.cell(20, 20), 0), 1);
}

}  // namespace
}  // namespace orphan_grid_test
