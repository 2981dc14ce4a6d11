#include "algorithms/corner_ring.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "asap/core/random.hpp"

namespace corner_ring_test {
namespace {

using asap::CornerRing;
using asap::kRing3;
using asap::kRing4;

// A window of 9 x 9 numbers, at whose centre the rings are read.
struct Window {
  static constexpr std::ptrdiff_t kStride = 9;
  std::array<std::int32_t, 81> numbers{};

  std::int32_t& at(asap::RingPixel pixel) {
    return numbers[static_cast<std::size_t>((pixel.dy + 4) * kStride + pixel.dx + 4)];
  }
  const std::int32_t* centre() const { return &numbers[40]; }
};

template <const auto& kPixels>
CornerRing<kPixels> ring_of(const std::vector<std::int32_t>& values) {
  Window window;
  for (std::size_t i = 0; i < kPixels.size(); ++i) window.at(kPixels[i]) = values[i];
  return CornerRing<kPixels>(window.centre(), Window::kStride);
}

template <const auto& kPixels>
void expect_circle(double radius) {
  for (std::size_t i = 0; i < kPixels.size(); ++i) {
    const asap::RingPixel pixel = kPixels[i];
    const asap::RingPixel next = kPixels[(i + 1) % kPixels.size()];
    EXPECT_NEAR(std::hypot(pixel.dx, pixel.dy), radius, 0.5);
    EXPECT_LE(std::abs(pixel.dx - next.dx), 1);
    EXPECT_LE(std::abs(pixel.dy - next.dy), 1);
    EXPECT_GT(pixel.dy * next.dx - pixel.dx * next.dy, 0);  // the same way round all along
    const asap::RingPixel opposite = kPixels[(i + kPixels.size() / 2) % kPixels.size()];
    EXPECT_EQ(pixel.dx, -opposite.dx);
    EXPECT_EQ(pixel.dy, -opposite.dy);
  }
}

TEST(CornerRing, PixelsAreCirclesSortedByAngle) {
  expect_circle<kRing3>(3);
  expect_circle<kRing4>(4);
  EXPECT_EQ(kRing3[0].dy, 3);
  EXPECT_EQ(kRing4[0].dy, 4);
}

template <const auto& kPixels>
void expect_answers() {
  constexpr auto kSize = kPixels.size();
  const asap::CounterRandom random(1);
  for (std::uint64_t i = 0; i < 500; ++i) {
    std::vector<std::int32_t> values;
    for (std::size_t j = 0; j < kSize; ++j) {
      values.push_back(static_cast<std::int32_t>(random(i * kSize + j) % 12));
    }
    const auto ring = ring_of<kPixels>(values);
    const auto newest = std::max_element(values.begin(), values.end()) - values.begin();
    ASSERT_EQ(ring.newest(), newest);
    for (std::int32_t bar = 0; bar < 13; ++bar) {
      std::uint32_t mask = 0;
      for (std::size_t j = 0; j < kSize; ++j) {
        mask |= static_cast<std::uint32_t>(values[j] >= bar) << j;
      }
      ASSERT_EQ(ring.at_least(bar), mask);
    }
    for (std::size_t j = 0; j < kSize; ++j) ASSERT_EQ(ring[static_cast<int>(j)], values[j]);
  }
}

TEST(CornerRing, AnswersAsItsValuesDo) {
  expect_answers<kRing3>();
  expect_answers<kRing4>();
}

TEST(CornerRing, OnlyTheLastPixelMayBeTheNewest) {
  std::vector<std::int32_t> values(20, 3);
  values[19] = 4;
  EXPECT_EQ(ring_of<kRing4>(values).newest(), 19);
}

TEST(CornerRing, IsClosed) {
  using Ring = CornerRing<kRing3>;
  EXPECT_EQ(Ring::after(15), 0);
  EXPECT_EQ(Ring::before(0), 15);
  EXPECT_EQ(Ring::after(3), 4);
  EXPECT_EQ(Ring::before(3), 2);
}

TEST(GrowingArc, GrowsToTheNewerNeighbourAndBackwardsInATie) {
  const auto ring = ring_of<kRing3>({9, 7, 5, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 5, 8});
  asap::GrowingArc arc(ring);
  EXPECT_EQ(arc.length(), 1);
  EXPECT_EQ(arc.oldest(), 9);
  EXPECT_EQ(arc.after(), 1);
  arc.grow_to(2);  // backwards, to pixel 15
  EXPECT_EQ(arc.oldest(), 8);
  EXPECT_EQ(arc.after(), 1);
  arc.grow_to(3);  // forwards, to pixel 1
  EXPECT_EQ(arc.oldest(), 7);
  EXPECT_EQ(arc.after(), 2);
  arc.grow_to(4);  // both are 5: backwards, to pixel 14
  EXPECT_EQ(arc.oldest(), 5);
  EXPECT_EQ(arc.after(), 2);
  arc.grow_to(2);
  EXPECT_EQ(arc.length(), 4);
}

}  // namespace
}  // namespace corner_ring_test
