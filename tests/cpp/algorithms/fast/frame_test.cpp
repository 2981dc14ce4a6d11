#include "algorithms/fast/frame.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

namespace frame_test {
namespace {

using namespace asap::fast;

TEST(Frame, IsLeftByWhatIsFarOutside) {
  const auto left = [](float x, float y, float vx = 0) {
    Track track;
    track.x = x;
    track.y = y;
    track.vx = vx;
    return has_left(track, 100'000, {.width = 20, .height = 10});
  };
  for (const auto& [x, y] : {std::pair{-3.0F, 5.0F}, {22.0F, 5.0F}, {5.0F, -3.0F}, {5.0F, 12.0F}}) {
    EXPECT_FALSE(left(x, y)) << x;
  }
  for (const auto& [x, y] : {std::pair{-3.1F, 5.0F}, {22.1F, 5.0F}, {5.0F, -3.1F}, {5.0F, 12.1F}}) {
    EXPECT_TRUE(left(x, y)) << x;
  }
  EXPECT_TRUE(left(15, 5, 80));  // by now
  EXPECT_TRUE(left(std::numeric_limits<float>::quiet_NaN(), 5));
}

}  // namespace
}  // namespace frame_test
