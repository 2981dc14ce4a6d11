#include "algorithms/fast/coarse_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "asap/core/random.hpp"

namespace coarse_index_test {
namespace {

using asap::fast::CoarseIndex;

std::vector<int> around(const CoarseIndex& index, std::size_t x, std::size_t y) {
  std::vector<int> slots;
  index.for_each_around(x, y, [&](CoarseIndex::Slot slot) { slots.push_back(slot); });
  std::sort(slots.begin(), slots.end());
  return slots;
}

// Against a list: every cluster within 32 px is found, none beyond 64.
TEST(CoarseIndex, FindsWhatIsNear) {
  const asap::CounterRandom random(1);
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
  index.remove(0);  // it is nowhere: nothing happens
}

}  // namespace
}  // namespace coarse_index_test
