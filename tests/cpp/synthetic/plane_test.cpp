#include "synthetic/plane.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace asap::plane_test {
namespace {

TEST(UnitVector, TurnsByTwiceTheArcTangentAndKeepsItsLength) {
  UnitVector direction;
  const double half_tangent = std::tan(std::numbers::pi / 10.0);
  for (int i = 1; i <= 1000; ++i) {
    direction = direction.turned(half_tangent);
    EXPECT_NEAR(direction.x, std::cos(i * std::numbers::pi / 5.0), 1e-12);
    EXPECT_NEAR(direction.y, std::sin(i * std::numbers::pi / 5.0), 1e-12);
  }
}

}  // namespace
}  // namespace asap::plane_test
