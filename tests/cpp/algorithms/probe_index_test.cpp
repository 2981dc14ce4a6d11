#include "algorithms/probe_index.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "algorithms/cell_grid.hpp"

namespace asap::probe_index_test {
namespace {

// ---- UniformProbe ---------------------------------------------------------------------------

using asap::ProbeDraw;
using asap::UniformProbe;

std::vector<std::uint64_t> draw(UniformProbe& probe, std::uint64_t count, int times) {
  std::vector<std::uint64_t> draws;
  for (int i = 0; i < times; ++i) {
    draws.push_back(probe(ProbeDraw{}, count, [](std::uint64_t member) { return member; }));
  }
  return draws;
}

TEST(UniformProbe, DrawsEveryMemberEquallyOften) {
  constexpr std::uint64_t kCount = 17;
  constexpr int kTimes = 170'000;
  UniformProbe probe(42);
  std::array<int, kCount> hits{};
  for (const auto member : draw(probe, kCount, kTimes)) {
    ASSERT_LT(member, kCount);
    ++hits[member];
  }
  double chi_square = 0;
  for (const int h : hits) chi_square += (h - 10'000.0) * (h - 10'000.0) / 10'000.0;
  EXPECT_LT(chi_square, 39.3);  // 99.9 % of chi-square with 16 degrees of freedom
}

TEST(UniformProbe, SameSeedSameDraws) {
  UniformProbe a(7);
  UniformProbe b(7);
  UniformProbe other(8);
  const auto first = draw(a, 1000, 100);
  EXPECT_EQ(draw(b, 1000, 100), first);
  EXPECT_NE(draw(other, 1000, 100), first);
  EXPECT_NE(draw(a, 1000, 100), first);
  a.clear();
  EXPECT_EQ(draw(a, 1000, 100), first);
}

// Pinned: the same on every compiler and platform.
TEST(UniformProbe, FirstDraws) {
  UniformProbe probe(0);
  EXPECT_EQ(draw(probe, 800, 6), (std::vector<std::uint64_t>{225, 521, 560, 309, 525, 630}));
}

// ---- ProbeIndex -----------------------------------------------------------------------------

using asap::CellGrid;
using asap::KeySet;
using asap::ProbeIndex;

std::set<int> near(const ProbeIndex& index, const CellGrid& grid, CellGrid::Cell cell) {
  std::set<int> keys;
  index.near(grid, cell).for_each([&](ProbeIndex::Key key) { keys.insert(key); });
  return keys;
}

TEST(ProbeIndex, EqualsAListOfEvents) {
  const CellGrid grid(100, 100, 9);  // 10 x 10 cells of 10 px
  constexpr std::uint16_t kCapacity = 40;
  constexpr int kOwners = 3;
  ProbeIndex index(grid.size(), kCapacity);
  ProbeIndex::Key keys[kOwners];
  for (std::uint16_t i = 0; i < kOwners; ++i) keys[i] = index.acquire(i);

  struct Where {
    int owner, x, y;
  };
  std::map<ProbeIndex::Position, Where> model;
  const auto cell_of = [&](const Where& w) {
    return grid.cell(static_cast<std::size_t>(w.x), static_cast<std::size_t>(w.y));
  };
  std::mt19937 random(1);
  const auto below = [&random](int n) {
    return static_cast<int>(random() % static_cast<unsigned>(n));
  };
  for (int step = 0; step < 4000; ++step) {
    const auto position = static_cast<ProbeIndex::Position>(below(kCapacity));
    if (model.contains(position)) {
      index.remove(keys[model[position].owner], cell_of(model[position]), position);
      model.erase(position);
    } else {
      model[position] = {.owner = below(kOwners), .x = below(100), .y = below(100)};
      index.add(keys[model[position].owner], cell_of(model[position]), position);
    }
    if (below(100) == 0) {  // one owner leaves and comes back without events
      const int owner = below(kOwners);
      index.release(keys[owner], [&](ProbeIndex::Position p) { return cell_of(model[p]); });
      std::erase_if(model, [&](const auto& item) { return item.second.owner == owner; });
      keys[owner] = index.acquire(static_cast<std::uint16_t>(owner));
    }

    const int x = below(100);
    const int y = below(100);
    std::set<int> expected;
    std::map<int, std::set<ProbeIndex::Position>> members;
    for (const auto& [p, w] : model) {
      if (std::abs(w.x / 10 - x / 10) <= 1 && std::abs(w.y / 10 - y / 10) <= 1) {
        expected.insert(keys[w.owner]);
      }
      members[w.owner].insert(p);
    }
    ASSERT_EQ(
        near(index, grid, grid.cell(static_cast<std::size_t>(x), static_cast<std::size_t>(y))),
        expected);
    for (const auto& [owner, positions] : members) {
      std::set<ProbeIndex::Position> found;
      for (std::size_t i = 0; i < positions.size(); ++i) found.insert(index.member(keys[owner], i));
      ASSERT_EQ(found, positions);
      ASSERT_EQ(index.owner(keys[owner]), owner);
    }
  }
}

TEST(ProbeIndex, KeysRunOutAndComeBack) {
  ProbeIndex index(1, 8);
  std::set<int> keys;
  for (std::uint16_t slot = 0; slot < KeySet::kKeys; ++slot) keys.insert(index.acquire(slot));
  EXPECT_EQ(keys.size(), KeySet::kKeys);
  EXPECT_FALSE(keys.contains(ProbeIndex::kNoKey));
  EXPECT_EQ(index.acquire(1), ProbeIndex::kNoKey);
  index.release(77, [](ProbeIndex::Position) { return std::size_t{0}; });
  EXPECT_EQ(index.acquire(500), 77);
  EXPECT_EQ(index.owner(77), 500);
}

TEST(ProbeIndex, ClearForgetsEventsAndKeys) {
  const CellGrid grid(10, 10, 9);
  ProbeIndex index(grid.size(), 4);
  const auto key = index.acquire(0);
  index.add(key, grid.cell(5, 5), 2);
  index.clear();
  EXPECT_TRUE(near(index, grid, grid.cell(5, 5)).empty());
  EXPECT_EQ(index.acquire(0), key);
  index.add(key, grid.cell(5, 5), 2);
  index.remove(key, grid.cell(5, 5), 2);
  EXPECT_TRUE(near(index, grid, grid.cell(5, 5)).empty());
}

}  // namespace
}  // namespace asap::probe_index_test
