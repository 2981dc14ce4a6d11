#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "asap/algorithms/cluster_tracker.hpp"

namespace cluster_outline_test {
namespace {

using asap::Cluster;
using asap::ClusterOutline;

Cluster cluster(double cxx, double cxy, double cyy, std::int64_t id = 7) {
  Cluster made{};
  made.id = id;
  made.x = 30;
  made.y = 20;
  made.vx = 100;
  made.vy = -50;
  made.cxx = cxx;
  made.cxy = cxy;
  made.cyy = cyy;
  return made;
}

// The covariance of an ellipse with these half-axes.
Cluster ellipse(double major, double minor, double angle) {
  const double along = major * major / 4;
  const double across = minor * minor / 4;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return cluster(along * c * c + across * s * s, (along - across) * c * s,
                 along * s * s + across * c * c);
}

TEST(ClusterOutline, HasTheAxesOfTheCovariance) {
  constexpr double kPi = std::numbers::pi;
  for (const double angle : {0.0, 0.3, kPi / 4, 1.5, -0.3, -1.5}) {
    const ClusterOutline outline = outline_of(ellipse(12, 5, angle));
    EXPECT_NEAR(outline.major, 12, 1e-9);
    EXPECT_NEAR(outline.minor, 5, 1e-9);
    EXPECT_NEAR(outline.angle, angle, 1e-9);
    EXPECT_EQ(outline.x, 30);
    EXPECT_EQ(outline.y, 20);
  }
}

TEST(ClusterOutline, TheAngleIsThatOfALine) {
  for (double angle = -7; angle < 7; angle += 0.1) {
    const ClusterOutline outline = outline_of(ellipse(12, 5, angle));
    EXPECT_LE(std::abs(outline.angle), std::numbers::pi / 2 + 1e-12);
    EXPECT_NEAR(std::sin(outline.angle - angle), 0, 1e-9);
  }
}

TEST(ClusterOutline, ALineHasNoWidth) {
  // As rounding may leave it: slightly indefinite.
  EXPECT_EQ(outline_of(cluster(4, 0, -1e-15)).minor, 0);
  EXPECT_EQ(outline_of(cluster(4, 0, -1e-15)).major, 4);
  EXPECT_EQ(outline_of(cluster(0, 0, 0)).major, 0);
}

TEST(ClusterOutline, OfAnId) {
  const std::array clusters{cluster(9, 0, 4, 2), cluster(25, 0, 4, 5)};
  EXPECT_EQ(asap::outline_of(5, clusters).value().major, 10);
  EXPECT_EQ(asap::outline_of(2, clusters).value().major, 6);
  EXPECT_FALSE(asap::outline_of(3, clusters));
  EXPECT_FALSE(asap::outline_of(3, {}));
}

}  // namespace
}  // namespace cluster_outline_test
