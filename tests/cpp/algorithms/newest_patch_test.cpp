#include "algorithms/newest_patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "algorithms/order_surface.hpp"
#include "core/random.hpp"

namespace asap::newest_patch_test {
namespace {

using asap::NewestPatch;
using asap::PatchRows;

constexpr std::ptrdiff_t kStride = 11;

// Numbers of a 9 x 9 window in rows of 11, between columns of numbers that must not count.
class Window {
 public:
  explicit Window(const std::vector<std::int32_t>& numbers) {
    all_.fill(std::numeric_limits<std::int32_t>::max());
    for (std::size_t i = 0; i < 81; ++i) all_[i / 9 * 11 + i % 9 + 1] = numbers[i];
  }
  const std::int32_t* centre() const { return &all_[4 * 11 + 5]; }

 private:
  std::array<std::int32_t, 99> all_;
};

PatchRows newest_by_sorting(const std::vector<std::int32_t>& numbers) {
  std::vector<std::int32_t> sorted = numbers;
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  PatchRows rows{};
  for (std::size_t i = 0; i < 81; ++i) {
    if (numbers[i] >= sorted[24]) rows[i / 9] |= 1U << (i % 9);
  }
  return rows;
}

// `fired` distinct numbers, spread evenly below `newest` or crowded at one end, by `shape`.
std::vector<std::int32_t> draw(std::uint64_t seed, std::size_t fired, std::int32_t newest,
                               std::uint64_t shape) {
  const asap::CounterRandom random(seed);
  std::vector<std::int32_t> distinct;
  for (std::uint64_t i = 0; distinct.size() < fired - 1; ++i) {
    double share = random.uniform(i);
    for (std::uint64_t j = 0; j < shape % 8; ++j) share *= random.uniform(1000 * (j + 1) + i);
    if (shape >= 8) share = 1 - share;
    const auto number = static_cast<std::int32_t>(1 + share * (newest - 2));
    if (number < newest && std::find(distinct.begin(), distinct.end(), number) == distinct.end()) {
      distinct.push_back(number);
    }
  }
  std::vector<std::int32_t> numbers(81);
  std::copy(distinct.begin(), distinct.end(), numbers.begin());
  for (std::size_t i = 80; i > 0; --i) std::swap(numbers[i], numbers[random(9999 + i) % (i + 1)]);
  const auto hole = std::find(numbers.begin(), numbers.end(), 0);
  std::swap(*hole, numbers[40]);
  numbers[40] = newest;
  return numbers;
}

TEST(NewestPatch, SelectsAsSortingDoes) {
  NewestPatch patch;  // one for all: what it remembers must not show
  std::uint64_t seed = 0;
  for (const std::size_t fired : {25U, 26U, 40U, 80U}) {
    for (const std::int32_t newest :
         {100, 5000, 10'000'000, std::numeric_limits<std::int32_t>::max() - 1}) {
      for (std::uint64_t shape = 0; shape < 16; ++shape) {
        if (newest == 100 && shape > 0) continue;
        const auto numbers = draw(++seed, fired, newest, shape);
        PatchRows rows;
        ASSERT_TRUE(patch.select(Window(numbers).centre(), kStride, rows)) << seed;
        ASSERT_EQ(rows, newest_by_sorting(numbers)) << seed;
      }
    }
  }
}

TEST(NewestPatch, AFullWindowOfNeighbouringNumbers) {
  NewestPatch patch;
  std::vector<std::int32_t> numbers;
  for (std::int32_t i = 0; i < 81; ++i) numbers.push_back(1 + i);
  std::swap(numbers[40], numbers[80]);
  PatchRows rows;
  ASSERT_TRUE(patch.select(Window(numbers).centre(), kStride, rows));
  EXPECT_EQ(rows, newest_by_sorting(numbers));
}

TEST(NewestPatch, FewerThan25AreNone) {
  NewestPatch patch;
  for (const std::size_t fired : {1U, 2U, 24U}) {
    for (const std::int32_t newest : {25, 1000, 1 << 30}) {
      PatchRows rows;
      EXPECT_FALSE(patch.select(Window(draw(1, fired, newest, 0)).centre(), kStride, rows));
    }
  }
  PatchRows rows;
  EXPECT_TRUE(patch.select(Window(draw(1, 25, 1000, 0)).centre(), kStride, rows));
}

}  // namespace
}  // namespace asap::newest_patch_test
