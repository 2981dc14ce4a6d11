#include "algorithms/fast/association.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "asap/core/random.hpp"

namespace asap::fast::association_test {
namespace {

// ---- cells ----

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
  const Stamp later = 77 + 1'200'000'000U;
  grid.scrub(later, Scrubber::kRound_us);
  EXPECT_EQ(grid[map.cell(3, 3)].stamp, long_before(later));
}

// ---- the tracks near a pixel ----

std::vector<int> around(const CoarseIndex& index, std::size_t x, std::size_t y) {
  std::vector<int> slots;
  index.for_each_around(x, y, [&](CoarseIndex::Slot slot) { slots.push_back(slot); });
  std::sort(slots.begin(), slots.end());
  return slots;
}

// Against a list: every cluster within 32 px is found, none beyond 64.
TEST(CoarseIndex, FindsWhatIsNear) {
  const CounterRandom random(1);
  CoarseIndex index(200, 150, 30);
  std::vector<std::pair<double, double>> places(30, {-1e9, 0});
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const auto slot = static_cast<CoarseIndex::Slot>(random(5 * i) % 30);
    if (random(5 * i + 1) % 3 == 0) {
      index.remove(slot);
      places[slot] = {-1e9, 0};
    } else {
      places[slot] = {200 * random.uniform(5 * i + 2), 150 * random.uniform(5 * i + 3)};
      index.place(slot, static_cast<float>(places[slot].first),
                  static_cast<float>(places[slot].second));
    }
    const std::size_t x = random(5 * i + 4) % 200;
    const std::size_t y = random(5 * i + 4) / 7 % 150;
    const auto found = around(index, x, y);
    for (int s = 0; s < 30; ++s) {
      const auto [px, py] = places[static_cast<std::size_t>(s)];
      const double far =
          std::max(std::abs(px - static_cast<double>(x)), std::abs(py - static_cast<double>(y)));
      const bool is_found = std::binary_search(found.begin(), found.end(), s);
      ASSERT_TRUE(is_found || far > 32) << i;
      ASSERT_TRUE(!is_found || far < 64) << i;
    }
  }
}

TEST(CoarseIndex, PositionsOutsideAreInTheNearestCell) {
  CoarseIndex index(100, 40, 4);
  index.place(0, -1000, -5);
  index.place(1, 1e9F, 1e9F);
  EXPECT_EQ(around(index, 0, 0), std::vector<int>{0});
  EXPECT_EQ(around(index, 99, 39), std::vector<int>{1});
  index.clear();
  EXPECT_TRUE(around(index, 0, 0).empty());
  index.remove(0);  // in no cell: nothing happens
}

// ---- contact ----

constexpr ContourRule kOutline{.clip_px = 5, .memory = 16, .min_known = 3};
constexpr ContactRule kRule{.variance_floor_px2 = 0.3F, .owner_cost = 0.8F};
const DirectionTable kDirections;

// Two confirmed disks of radius 8 at x = 0 and x = `gap`, with known outlines, in contact.
struct TwoDisks {
  explicit TwoDisks(float gap) {
    for (const float x : {0.0F, gap}) {
      const auto slot = tracks.create(x, 0, 0);
      tracks[slot].phase = Phase::kConfirmed;
      tracks[slot].inverse_circle2 = 1 / 144.0F;
      tracks[slot].qa = tracks[slot].qc = 1;
      Contour& contour = tracks.contour(slot);
      contour.radius.fill(8);
      contour.count.fill(16);
      contour.variance = 0.5F;
    }
    for (const Tracks::Slot slot : {a, b}) {
      tracks[slot].partners = 1;
      tracks.state(slot).partners[0] = slot == a ? b : a;
    }
  }
  Tracks::Slot winner(Tracks::Slot owner, float x) {
    return associate_in_contact(tracks, owner, 0, x, 0, kOutline, kRule, kDirections);
  }
  Tracks tracks{2};
  Tracks::Slot a = 0;
  Tracks::Slot b = 1;
};

TEST(Contact, TheOutlineThatFitsWins) {
  TwoDisks disks(18);
  EXPECT_EQ(disks.winner(disks.b, 8), disks.a);  // on a's outline, 2 px off b's
  EXPECT_EQ(disks.winner(disks.a, 10), disks.b);
  EXPECT_EQ(disks.winner(disks.a, 8), disks.a);
}

TEST(Contact, TheOwnerHasAnAdvantage) {
  TwoDisks disks(18);
  EXPECT_EQ(disks.winner(disks.a, 9), disks.a);  // as far from both
  EXPECT_EQ(disks.winner(disks.b, 9), disks.b);
}

TEST(Contact, OnlyPartnersWithAnIdAndTheEventInTheirGateCompete) {
  TwoDisks disks(18);
  disks.tracks[disks.a].phase = Phase::kTentative;
  EXPECT_EQ(disks.winner(disks.b, 8), disks.b);
  disks.tracks[disks.a].phase = Phase::kCoasting;
  EXPECT_EQ(disks.winner(disks.b, 8), disks.a);
  disks.tracks[disks.a].inverse_circle2 = 1 / 49.0F;
  EXPECT_EQ(disks.winner(disks.b, 8), disks.b);
}

TEST(Contact, WithoutAnOutlineTheGateDecides) {
  const Contour unknown;
  const Innovation nu{0, 0, 8, 0};
  EXPECT_FLOAT_EQ(contact_cost(unknown, nu, 4.0F / 9, 0, kOutline, kRule), 0);
  EXPECT_FLOAT_EQ(contact_cost(unknown, nu, 1, 0, kOutline, kRule), 2);
  EXPECT_FLOAT_EQ(contact_cost(unknown, nu, 0, 0, kOutline, kRule), 4);
}

}  // namespace
}  // namespace asap::fast::association_test
