#include "algorithms/newest_patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "algorithms/corner_streams.hpp"
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

// On a machine without AVX2 both paths are the portable one.
class NewestPatchPaths : public testing::TestWithParam<NewestPatch::Path> {};

INSTANTIATE_TEST_SUITE_P(NewestPatch, NewestPatchPaths,
                         testing::Values(NewestPatch::Path::fastest, NewestPatch::Path::portable));

TEST_P(NewestPatchPaths, SelectsAsSortingDoes) {
  NewestPatch patch(GetParam());  // one for all: what it remembers must not show
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

TEST_P(NewestPatchPaths, AFullWindowOfNeighbouringNumbers) {
  NewestPatch patch(GetParam());
  std::vector<std::int32_t> numbers;
  for (std::int32_t i = 0; i < 81; ++i) numbers.push_back(1 + i);
  std::swap(numbers[40], numbers[80]);
  PatchRows rows;
  ASSERT_TRUE(patch.select(Window(numbers).centre(), kStride, rows));
  EXPECT_EQ(rows, newest_by_sorting(numbers));
}

TEST_P(NewestPatchPaths, FewerThan25AreNone) {
  NewestPatch patch(GetParam());
  for (const std::size_t fired : {1U, 2U, 24U}) {
    for (const std::int32_t newest : {25, 1000, 1 << 30}) {
      PatchRows rows;
      EXPECT_FALSE(patch.select(Window(draw(1, fired, newest, 0)).centre(), kStride, rows));
    }
  }
  PatchRows rows;
  EXPECT_TRUE(patch.select(Window(draw(1, 25, 1000, 0)).centre(), kStride, rows));
}

// ---- select_avx2 ----------------------------------------------------------------------------

using asap::Event;
using asap::OrderSurface;
using asap::PatchSearch;

// Every window of a stream on both paths: the same patches, so the same scores and labels.
void expect_the_same_patches(const asap::SensorFrame& frame, const std::vector<Event>& events) {
  OrderSurface surface(frame);
  NewestPatch fastest(NewestPatch::Path::fastest);
  NewestPatch portable(NewestPatch::Path::portable);
  for (std::size_t i = 0; i < events.size(); ++i) {
    OrderSurface::Number* pixel = surface.pixel(events[i]);
    *pixel = surface.next();
    if (!frame.contains(events[i], 4)) continue;
    PatchRows a, b;
    const bool found = portable.select(pixel, surface.stride(), b);
    ASSERT_EQ(fastest.select(pixel, surface.stride(), a), found) << i;
    if (found) {
      ASSERT_EQ(a, b) << i;
    }
  }
}

TEST(NewestPatchAvx2, AgreesWithThePortablePath) {
  const asap::SensorFrame frame(346, 260);
  expect_the_same_patches(frame, asap::test::golden_corner_stream());
  expect_the_same_patches(frame, asap::test::turning_shapes({.speed = 700}, 100'000));
  expect_the_same_patches(frame,
                          asap::test::turning_shapes({.speed = 300, .noise_hz = 8}, 100'000));
  for (const auto& wild : asap::test::wild_streams()) {
    expect_the_same_patches(asap::SensorFrame(wild.width, wild.height),
                            asap::test::wild_stream(wild, 6000));
  }
}

class Pixels {
 public:
  Pixels() { numbers_.fill(OrderSurface::kNever); }
  OrderSurface::Number& operator()(std::size_t x, std::size_t y) { return numbers_[9 * y + x]; }
  PatchSearch select(OrderSurface::Number depth, PatchRows& rows) {
    return asap::select_avx2(&numbers_[40], 9, depth, rows);
  }

 private:
  std::array<OrderSurface::Number, 81> numbers_;
};

// Each pixel alone among the newest, and each alone among the oldest.
TEST(NewestPatchAvx2, FindsEveryPixelInItsPlace) {
  if (!asap::has_avx2()) GTEST_SKIP() << "this machine has no AVX2";
  for (std::size_t place = 0; place < 81; ++place) {
    if (place == 40) continue;
    Pixels pixels;
    OrderSurface::Number number = 1000;
    PatchRows expected{};
    expected[4] = 1U << 4;
    const auto fire = [&](std::size_t i) { pixels(i % 9, i / 9) = number--; };
    fire(40);
    std::size_t picked = 1;
    for (std::size_t i = place; picked < 25; i = (i + 1) % 81) {
      if (i == 40) continue;
      fire(i);
      expected[i / 9] |= 1U << (i % 9);
      ++picked;
    }
    for (std::size_t i = 0; i < 81; ++i) {
      if (pixels(i % 9, i / 9) == OrderSurface::kNever) fire(i);
    }
    PatchRows rows;
    ASSERT_EQ(pixels.select(64, rows), PatchSearch::found) << place;
    ASSERT_EQ(rows, expected) << place;
  }
}

TEST(NewestPatchAvx2, LeavesToThePortablePathWhatItCannotTell) {
  if (!asap::has_avx2()) GTEST_SKIP() << "this machine has no AVX2";
  Pixels pixels;
  for (std::size_t i = 0; i < 81; ++i) {
    pixels(i % 9, i / 9) = 1'000'000'000 - static_cast<OrderSurface::Number>(i);
  }
  pixels(4, 4) = 2'000'000'000;
  PatchRows rows;
  EXPECT_EQ(pixels.select(64, rows), PatchSearch::unresolved);             // far below the guess
  EXPECT_EQ(pixels.select(1'000'000'000, rows), PatchSearch::unresolved);  // too close together
  for (std::size_t i = 0; i < 36; ++i) pixels(i % 9, i / 9) = OrderSurface::kNever;
  for (std::size_t i = 60; i < 81; ++i) pixels(i % 9, i / 9) = OrderSurface::kNever;
  EXPECT_EQ(pixels.select(64, rows), PatchSearch::too_few);  // 24 have fired
  EXPECT_EQ(pixels.select(1'000'000'000, rows), PatchSearch::too_few);
}

}  // namespace
}  // namespace asap::newest_patch_test
