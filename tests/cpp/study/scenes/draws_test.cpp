#include "study/scenes/draws.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace asap::draws_test {
namespace {

using scenes::Draws;

TEST(Draws, AreThoseOfSeedAndLayout) {
  Draws one{3, 5};
  Draws again{3, 5};
  Draws other{3, 6};
  const double first = one.from({2.0, 4.0});
  EXPECT_TRUE(first >= 2.0 && first < 4.0);
  EXPECT_EQ(again.from({2.0, 4.0}), first);
  EXPECT_NE(other.from({2.0, 4.0}), first);
  EXPECT_NE(one.from({2.0, 4.0}), first);
}

TEST(Draws, VelocitiesHaveTheirSpeedAndEveryDirection) {
  Draws draws{1, 2};
  PlanePoint sum{0.0, 0.0};
  for (int i = 0; i < 1000; ++i) {
    const PlanePoint velocity = draws.velocity({50.0, 60.0});
    const double speed = std::sqrt(velocity.x * velocity.x + velocity.y * velocity.y);
    ASSERT_TRUE(speed >= 50.0 - 1e-9 && speed <= 60.0 + 1e-9);
    sum.x += velocity.x;
    sum.y += velocity.y;
  }
  EXPECT_LT(std::abs(sum.x) + std::abs(sum.y), 6000.0);
}

TEST(Draws, ABoxKeepsItsMargin) {
  const Bounce box = scenes::bounce_in(100, 80, 10.0);
  EXPECT_EQ(box.low.x, 10.0);
  EXPECT_EQ(box.high.x, 89.0);
  EXPECT_EQ(box.high.y, 69.0);
}

}  // namespace
}  // namespace asap::draws_test
