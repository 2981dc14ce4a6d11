#include "algorithms/arc_length.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "algorithms/naive_corners.hpp"
#include "asap/core/random.hpp"

namespace arc_length_test {
namespace {

using asap::CornerRing;
using asap::kRing3;
using asap::kRing4;

constexpr std::ptrdiff_t kStride = 9;
using Window = std::array<std::int32_t, 81>;  // the rings lie around number 40

template <const auto& kPixels>
Window window_of(const std::vector<std::int32_t>& values) {
  Window window{};
  for (std::size_t i = 0; i < kPixels.size(); ++i) {
    window[static_cast<std::size_t>(40 + kPixels[i].dy * kStride + kPixels[i].dx)] = values[i];
  }
  return window;
}

template <const auto& kPixels>
int length_of(const std::vector<std::int32_t>& values, int shortest) {
  const Window window = window_of<kPixels>(values);
  return asap::arc_length(CornerRing<kPixels>(&window[40], kStride), shortest);
}

TEST(ArcLength, OfASingleStep) {
  std::vector<std::int32_t> values(16, 1);
  for (const std::size_t i : {15U, 0U, 1U, 2U, 3U}) values[i] = 2;
  EXPECT_EQ(length_of<kRing3>(values, 3), 5);
}

TEST(ArcLength, OfARingWithoutAStep) {
  EXPECT_EQ(length_of<kRing3>(std::vector<std::int32_t>(16, 1), 3), 16);
  EXPECT_EQ(length_of<kRing4>(std::vector<std::int32_t>(20, 1), 4), 20);
}

// Pixel 6 is as new as the arc of pixels 0 to 2 and lies behind three older ones: the arc takes
// them in. It is then as old as 3 and takes in the 4 at the other side as well.
TEST(ArcLength, TakesInWhatItPassedOver) {
  std::vector<std::int32_t> values(16, 1);
  values[0] = 9;
  values[1] = 8;
  values[2] = 7;
  values[3] = values[4] = values[5] = 3;
  values[6] = 7;
  EXPECT_EQ(length_of<kRing3>(values, 3), 7);
  values[15] = 2;
  values[14] = 4;
  EXPECT_EQ(length_of<kRing3>(values, 3), 7 + 2);
}

template <const auto& kPixels>
void expect_naive_lengths(int shortest) {
  constexpr auto kSize = kPixels.size();
  const asap::CounterRandom random(7);
  std::vector<int> seen(kSize + 1);
  for (std::uint64_t i = 0; i < 30'000; ++i) {
    // Few values, many ties; in two of three rings a slope, as an edge leaves it.
    const std::uint64_t levels = 2 + random(100 * i) % 30;
    const std::uint64_t turn = random(100 * i + 1) % kSize;
    const std::uint64_t slope = random(100 * i + 2) % 3;
    std::vector<std::int32_t> values(kSize);
    std::vector<asap::test::Stamp> stamps(kSize);
    for (std::size_t j = 0; j < kSize; ++j) {
      const std::uint64_t place = (j + turn) % kSize;
      const std::uint64_t from_end = std::min<std::uint64_t>(place, kSize - place);
      const auto value =
          static_cast<std::int32_t>(random(100 * i + 3 + j) % levels + slope * 2 * from_end);
      values[j] = value;
      stamps[j] = value;
    }
    const int expected = asap::test::naive_arc_length(stamps, shortest);
    ASSERT_EQ(length_of<kPixels>(values, shortest), expected);
    ++seen[static_cast<std::size_t>(expected)];
  }
  for (auto length = static_cast<std::size_t>(shortest); length <= kSize; ++length) {
    EXPECT_GT(seen[length], 0) << length;
  }
}

TEST(ArcLength, IsTheLengthOfTheDefinition) {
  expect_naive_lengths<kRing3>(3);
  expect_naive_lengths<kRing4>(4);
}

// Both rings at once, each an arc of new pixels.
bool corner_arcs(std::size_t inner, std::size_t outer) {
  std::vector<std::int32_t> values(16, 1);
  for (std::size_t i = 0; i < inner; ++i) values[i] = 2;
  Window window = window_of<kRing3>(values);
  for (std::size_t i = 0; i < kRing4.size(); ++i) {
    window[static_cast<std::size_t>(40 + kRing4[i].dy * kStride + kRing4[i].dx)] =
        i < outer ? 2 : 1;
  }
  return asap::has_corner_arcs(&window[40], kStride);
}

TEST(ArcLength, CornersHaveAShortArcOrAShortRest) {
  for (std::size_t inner = 3; inner <= 16; ++inner) {
    for (std::size_t outer = 4; outer <= 20; ++outer) {
      const bool expected = (inner <= 6 || (10 <= inner && inner <= 13)) &&
                            (outer <= 8 || (12 <= outer && outer <= 16));
      EXPECT_EQ(corner_arcs(inner, outer), expected) << inner << ' ' << outer;
    }
  }
}

}  // namespace
}  // namespace arc_length_test
