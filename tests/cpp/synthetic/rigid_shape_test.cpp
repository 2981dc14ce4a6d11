#include "synthetic/rigid_shape.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace asap::rigid_shape_test {
namespace {

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

TEST(RigidShape, VerticesLieOnTheOutlineAndOneReachesFarthest) {
  const std::size_t sizes[] = {0, 4, 4, 3, 10};
  for (std::size_t i = 0; i < RigidShape::kKinds; ++i) {
    const RigidShape shape{kKinds[i], 8.0};
    EXPECT_EQ(shape.vertices().size(), sizes[i]);
    double farthest = i == 0 ? 8.0 : 0.0;
    for (const PlanePoint vertex : shape.vertices()) {
      EXPECT_NEAR(shape.distance_px(vertex), 0.0, 1e-12);
      farthest = std::max(farthest, std::sqrt(vertex.x * vertex.x + vertex.y * vertex.y));
    }
    EXPECT_DOUBLE_EQ(shape.reach_px(), farthest);
  }
  EXPECT_NEAR(RigidShape(ShapeKind::kTriangle, 10.0).reach_px(), 12.0, 1e-12);
  EXPECT_NEAR(RigidShape(ShapeKind::kStar, 10.0).reach_px(), 13.0, 1e-12);
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

TEST(RigidShape, RefusesABadRadius) {
  for (const double radius_px : {0.9, 1001.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(RigidShape(ShapeKind::kDisk, radius_px), std::invalid_argument);
  }
}

}  // namespace
}  // namespace asap::rigid_shape_test
