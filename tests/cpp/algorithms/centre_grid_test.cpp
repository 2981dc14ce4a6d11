#include "algorithms/centre_grid.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <set>

namespace centre_grid_test {
namespace {

using asap::CentreGrid;

std::set<CentreGrid::Slot> in(const CentreGrid& grid, std::size_t cell) {
  std::set<CentreGrid::Slot> slots;
  for (auto slot = grid.first(cell); slot != CentreGrid::kNone; slot = grid.next(slot)) {
    EXPECT_TRUE(slots.insert(slot).second) << "a loop at slot " << slot;
    if (slots.size() > 100) break;
  }
  return slots;
}

TEST(CentreGrid, IsEmptyAtFirst) {
  const CentreGrid grid(3, 4);
  for (std::size_t cell = 0; cell < 3; ++cell) EXPECT_TRUE(in(grid, cell).empty());
}

TEST(CentreGrid, EqualsASetPerCell) {
  constexpr std::size_t kCells = 5;
  constexpr std::uint16_t kSlots = 12;
  CentreGrid grid(kCells, kSlots);
  std::map<CentreGrid::Slot, std::uint16_t> model;  // slot -> cell
  std::mt19937 random(1);
  for (int step = 0; step < 5000; ++step) {
    const auto slot = static_cast<CentreGrid::Slot>(random() % kSlots);
    const auto cell = static_cast<std::uint16_t>(random() % kCells);
    if (!model.contains(slot)) {
      grid.enter(slot, cell);
      model[slot] = cell;
    } else if (random() % 2 == 0) {
      grid.move(slot, cell);
      model[slot] = cell;
    } else {
      grid.leave(slot);
      model.erase(slot);
    }
    for (std::size_t c = 0; c < kCells; ++c) {
      std::set<CentreGrid::Slot> expected;
      for (const auto& [s, at] : model) {
        if (at == c) expected.insert(s);
      }
      ASSERT_EQ(in(grid, c), expected) << "step " << step << ", cell " << c;
    }
  }
}

TEST(CentreGrid, ClearEmptiesEveryCell) {
  CentreGrid grid(2, 2);
  grid.enter(0, 1);
  grid.clear();
  EXPECT_TRUE(in(grid, 1).empty());
}

}  // namespace
}  // namespace centre_grid_test
