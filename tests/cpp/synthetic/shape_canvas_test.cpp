#include "synthetic/shape_canvas.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace asap::shape_canvas_test {
namespace {

constexpr std::int32_t kWidth = 40;
constexpr std::int32_t kHeight = 30;

constexpr std::uint32_t at(std::uint32_t x, std::uint32_t y) { return x + kWidth * y; }

Pose pose(double x, double y) { return {.position{x, y}, .velocity{}, .axis{}}; }

class Canvas : public ::testing::Test {
 protected:
  ShapeCanvas canvas_{kWidth, kHeight, 0.5};
  RigidShape square_{ShapeKind::kSquare, 5.0};
};

TEST_F(Canvas, MixesGroundAndShapeByCoverage) {
  canvas_.begin();
  canvas_.paint(square_, pose(10.25, 10.0), 0.1, 3);
  EXPECT_DOUBLE_EQ(canvas_.brightness(at(10, 10)), 0.1);
  EXPECT_DOUBLE_EQ(canvas_.brightness(at(15, 10)), 0.5 * 0.25 + 0.1 * 0.75);  // ends at 15.25
  EXPECT_DOUBLE_EQ(canvas_.brightness(at(17, 10)), 0.5);
  EXPECT_EQ(canvas_.owner(at(15, 10)), 3);
  EXPECT_EQ(canvas_.owner(at(17, 10)), ShapeCanvas::kNobody);
}

TEST_F(Canvas, TurnsTheShape) {
  canvas_.begin();
  const RigidShape bar{ShapeKind::kRectangle, 8.0};
  canvas_.paint(bar, {.position{20.0, 15.0}, .velocity{}, .axis{0.0, 1.0}}, 0.1, 0);
  EXPECT_EQ(canvas_.brightness(at(20, 22)), 0.1);
  EXPECT_EQ(canvas_.brightness(at(27, 15)), 0.5);

  const RigidShape triangle{ShapeKind::kTriangle, 8.0};  // its corner up, turned to the right
  canvas_.begin();
  canvas_.paint(triangle, {.position{20.0, 15.0}, .velocity{}, .axis{0.0, 1.0}}, 0.1, 0);
  EXPECT_EQ(canvas_.brightness(at(28, 15)), 0.1);
  EXPECT_EQ(canvas_.brightness(at(12, 15)), 0.5);
}

TEST_F(Canvas, LaterShapesHideEarlierOnes) {
  canvas_.begin();
  canvas_.paint(square_, pose(10.0, 10.0), 0.1, 0);
  canvas_.paint(square_, pose(13.5, 10.0), 0.9, 1);  // from 8.5: a pixel at 8 is not covered
  EXPECT_DOUBLE_EQ(canvas_.brightness(at(7, 10)), 0.1);
  EXPECT_DOUBLE_EQ(canvas_.brightness(at(10, 10)), 0.9);
  EXPECT_EQ(canvas_.owner(at(7, 10)), 0);
  EXPECT_EQ(canvas_.owner(at(10, 10)), 1);
}

TEST_F(Canvas, ForgetsAShapeThatMovedButNotWhoWasThere) {
  const RigidShape disk{ShapeKind::kDisk, 5.0};
  canvas_.begin();
  canvas_.paint(disk, pose(10.25, 10.0), 0.1, 7);
  ASSERT_DOUBLE_EQ(canvas_.brightness(at(5, 10)), 0.5 * 0.75 + 0.1 * 0.25);
  canvas_.begin();
  canvas_.paint(disk, pose(11.25, 10.0), 0.1, 7);
  EXPECT_EQ(canvas_.brightness(at(5, 10)), 0.5);
  EXPECT_EQ(canvas_.owner(at(5, 10)), 7);
  EXPECT_TRUE(std::ranges::count(canvas_.touched(), at(5, 10)) == 1);
}

TEST_F(Canvas, TouchesEachPixelNearAShapeOnce) {
  canvas_.begin();
  canvas_.paint(square_, pose(2.0, 3.0), 0.1, 0);
  canvas_.paint(square_, pose(4.0, 3.0), 0.1, 1);
  canvas_.paint(square_, pose(39.0, 29.0), 0.1, 2);
  canvas_.paint(square_, pose(-500.0, 1e5), 0.1, 3);
  const auto touched = canvas_.touched();
  EXPECT_EQ(std::set<std::uint32_t>(touched.begin(), touched.end()).size(), touched.size());
  EXPECT_LT(touched.size(), 400U);
  EXPECT_EQ(std::ranges::count(touched, at(39, 29)), 1);
  EXPECT_EQ(std::ranges::count(touched, at(20, 15)), 0);
  canvas_.begin();
  EXPECT_TRUE(canvas_.touched().empty());
}

}  // namespace
}  // namespace asap::shape_canvas_test
