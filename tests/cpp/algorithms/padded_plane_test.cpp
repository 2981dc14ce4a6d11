#include "algorithms/padded_plane.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "support/errors.hpp"

namespace padded_plane_test {
namespace {

using asap::Event;
using asap::SensorFrame;
using Bytes = asap::PaddedPlane<std::uint8_t>;
using Words = asap::PaddedPlane<std::uint16_t>;

TEST(PaddedPlane, AWindowLiesAroundItsPixel) {
  Bytes plane(SensorFrame(20, 10), 3);
  for (const std::uint32_t x : {0U, 7U, 19U}) {
    for (const std::uint32_t y : {0U, 4U, 9U}) {
      const Event event{
          .x = static_cast<std::uint16_t>(x), .y = static_cast<std::uint16_t>(y), .p = 0, .t = 0};
      EXPECT_EQ(plane.corner(event) + 3 * plane.stride() + 3, plane.pixel(x, y));
    }
  }
}

TEST(PaddedPlane, BlocksHoldTheWindowAndNoMore) {
  EXPECT_EQ(Bytes::kLanes, 16U);
  EXPECT_EQ(Words::kLanes, 8U);
  const SensorFrame frame(20, 10);
  EXPECT_EQ(Bytes(frame, 1).blocks(), 1U);
  EXPECT_EQ(Bytes(frame, 7).blocks(), 1U);   // 15 values
  EXPECT_EQ(Bytes(frame, 8).blocks(), 2U);   // 17
  EXPECT_EQ(Words(frame, 3).blocks(), 1U);   // 7
  EXPECT_EQ(Words(frame, 6).blocks(), 2U);   // 13
  EXPECT_EQ(Words(frame, 12).blocks(), 4U);  // 25
}

TEST(PaddedPlane, BlocksOfAWindowEndInItsRow) {
  for (const std::uint32_t reach : {1U, 6U, 7U, 8U, 63U}) {
    Words plane(SensorFrame(20, 10), reach);
    const Event last{.x = 19, .y = 9, .p = 0, .t = 0};
    const auto first_row = plane.pixel(0, 9) - reach - reach * plane.stride();
    const auto beyond =
        plane.corner(last) + static_cast<std::ptrdiff_t>(plane.blocks() * Words::kLanes);
    EXPECT_LE(beyond - first_row, plane.stride()) << reach;
  }
}

TEST(PaddedPlane, CopiesTheFrameRowByRow) {
  Words plane(SensorFrame(3, 2), 4);
  for (std::uint32_t y = 0; y < 2; ++y) {
    for (std::uint32_t x = 0; x < 3; ++x) {
      *plane.pixel(x, y) = static_cast<std::uint16_t>(10 * y + x + 1);
    }
  }
  *(plane.pixel(0, 0) - 1) = 99;
  EXPECT_EQ(plane.at(2, 1), 13);
  std::vector<std::uint16_t> copy(6);
  plane.copy_to(copy);
  EXPECT_EQ(copy, (std::vector<std::uint16_t>{1, 2, 3, 11, 12, 13}));
  plane.clear();
  EXPECT_EQ(*(plane.pixel(0, 0) - 1), 0);
  EXPECT_EQ(plane.at(2, 1), 0);

  std::vector<std::uint16_t> small(5);
  EXPECT_EQ(asap::test::error_of([&] { plane.copy_to(small); }),
            "out.size() = 5: must be width x height");
}

}  // namespace
}  // namespace padded_plane_test
