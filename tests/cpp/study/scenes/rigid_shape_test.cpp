#include "study/scenes/rigid_shape.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace asap::rigid_shape_test {
namespace {

// ---- RigidShape -----------------------------------------------------------------------------

constexpr ShapeKind kKinds[] = {ShapeKind::kDisk, ShapeKind::kSquare, ShapeKind::kRectangle,
                                ShapeKind::kTriangle, ShapeKind::kStar};

TEST(RigidShape, DistancesByHand) {
  const RigidShape disk{ShapeKind::kDisk, 10.0};
  EXPECT_DOUBLE_EQ(disk.distance_px({0.0, 0.0}), -10.0);
  EXPECT_DOUBLE_EQ(disk.distance_px({6.0, 8.0}), 0.0);
  EXPECT_DOUBLE_EQ(disk.distance_px({-9.0, 12.0}), 5.0);

  const RigidShape square{ShapeKind::kSquare, 10.0};
  EXPECT_DOUBLE_EQ(square.distance_px({0.0, 0.0}), -10.0);
  EXPECT_DOUBLE_EQ(square.distance_px({7.0, -2.0}), -3.0);
  EXPECT_DOUBLE_EQ(square.distance_px({13.0, 14.0}), 5.0);  // to the corner
  EXPECT_DOUBLE_EQ(square.distance_px({0.0, -12.0}), 2.0);

  const RigidShape rectangle{ShapeKind::kRectangle, 10.0};
  EXPECT_DOUBLE_EQ(rectangle.distance_px({0.0, 0.0}), -5.0);
  EXPECT_DOUBLE_EQ(rectangle.distance_px({9.5, 0.0}), -0.5);
  EXPECT_DOUBLE_EQ(rectangle.distance_px({0.0, 6.0}), 1.0);

  const RigidShape triangle{ShapeKind::kTriangle, 10.0};  // corner up, side at y = 6
  EXPECT_NEAR(triangle.distance_px({0.0, 0.0}), -6.0, 1e-12);
  EXPECT_NEAR(triangle.distance_px({0.0, 8.0}), 2.0, 1e-12);
  EXPECT_NEAR(triangle.distance_px({0.0, -13.0}), 1.0, 1e-12);

  const RigidShape star{ShapeKind::kStar, 10.0};
  EXPECT_NEAR(star.distance_px({0.0, -15.0}), 2.0, 1e-12);  // to the upper tip
  EXPECT_NEAR(star.distance_px({0.0, 5.0}), 0.0, 1e-12);    // the notch below
  EXPECT_LT(star.distance_px({0.0, -12.0}), 0.0);
  EXPECT_GT(star.distance_px({0.0, 12.0}), 0.0);
}

// Where coverage() takes a short cut it has to agree with the distance.
TEST(RigidShape, CoverageIsTheClampedDistance) {
  for (const ShapeKind kind : kKinds) {
    const RigidShape shape{kind, 6.3};
    for (double y = -11.0; y < 11.0; y += 0.23) {
      for (double x = -11.0; x < 11.0; x += 0.23) {
        const double expected = std::clamp(0.5 - shape.distance_px({x, y}), 0.0, 1.0);
        EXPECT_NEAR(shape.coverage({x, y}), expected, 1e-12) << x << " " << y;
        const double from_centre = std::sqrt(x * x + y * y);
        if (from_centre < shape.inner_px()) {
          EXPECT_LT(shape.distance_px({x, y}), 0.0);
        }
        if (from_centre > shape.reach_px()) {
          EXPECT_GT(shape.distance_px({x, y}), 0.0);
        }
      }
    }
  }
}

TEST(RigidShape, ThickKindsByHand) {
  const RigidShape bar{ShapeKind::kBar, 30.0, 8.0};
  EXPECT_DOUBLE_EQ(bar.distance_px({0.0, 0.0}), -4.0);
  EXPECT_DOUBLE_EQ(bar.distance_px({33.0, 8.0}), 5.0);
  EXPECT_DOUBLE_EQ(bar.inner_px(), 4.0);

  const RigidShape ring{ShapeKind::kRing, 20.0, 4.0};
  EXPECT_DOUBLE_EQ(ring.distance_px({0.0, 0.0}), 16.0);
  EXPECT_DOUBLE_EQ(ring.distance_px({0.0, 18.0}), -2.0);
  EXPECT_DOUBLE_EQ(ring.distance_px({-15.0, 0.0}), 1.0);
  EXPECT_DOUBLE_EQ(ring.distance_px({0.0, -23.0}), 3.0);
  EXPECT_LT(ring.inner_px(), 0.0);
  EXPECT_TRUE(ring.vertices().empty());
}

TEST(RigidShape, AnAngleIsAnLAboutItsCentreOfArea) {
  const RigidShape angle{ShapeKind::kAngle, 40.0, 10.0};
  ASSERT_EQ(angle.vertices().size(), 6U);
  const PlanePoint corner = angle.vertices()[0];
  double area = 0.0;
  PlanePoint moment{0.0, 0.0};
  for (double x = 0.25; x < 40.0; x += 0.5) {
    for (double y = 0.25; y < 40.0; y += 0.5) {
      const PlanePoint point{corner.x + x, corner.y + y};
      const bool inside = x < 10.0 || y < 10.0;
      ASSERT_EQ(angle.distance_px(point) < 0.0, inside) << x << " " << y;
      area += inside;
      moment.x += inside ? point.x : 0.0;
      moment.y += inside ? point.y : 0.0;
    }
  }
  EXPECT_NEAR(moment.x / area, 0.0, 1e-9);
  EXPECT_NEAR(moment.y / area, 0.0, 1e-9);
}

// ---- ShapeCanvas ----------------------------------------------------------------------------

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
  EXPECT_EQ(canvas_.owner(at(17, 10)), ShapeCanvas::kNone);
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

}  // namespace
}  // namespace asap::rigid_shape_test
