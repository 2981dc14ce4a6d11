#include "algorithms/fast/contour.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

namespace asap::fast::contour_test {
namespace {

constexpr ContourRule kRule{.clip_px = 5, .memory = 16, .min_known = 3};

TEST(DirectionTable, HasSixteenEvenBins) {
  const DirectionTable table;
  std::set<std::size_t> bins;
  for (std::size_t k = 0; k < kContourBins; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kContourBins;
    for (const double off : {-0.15, 0.0, 0.15}) {
      EXPECT_EQ(table.bin(static_cast<float>(25 * std::cos(angle + off)),
                          static_cast<float>(25 * std::sin(angle + off))),
                k);
    }
    bins.insert(
        table.bin(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))));
  }
  EXPECT_LE(bins.size(), kContourBins);
}

TEST(DirectionTable, TakesAnyDisplacement) {
  const DirectionTable table;
  EXPECT_EQ(table.bin(1e30F, 0), 0U);
  EXPECT_EQ(table.bin(0, 1e30F), 4U);
  EXPECT_EQ(table.bin(-1e30F, 0), 8U);
  EXPECT_LT(table.bin(-0.0F, 0), kContourBins);
}

TEST(Contour, LearnsTheRadiusOfADirection) {
  Contour contour;
  contour.learn(3, 10, kRule);
  contour.learn(3, 12, kRule);
  EXPECT_FALSE(contour.known(3, kRule));
  EXPECT_FLOAT_EQ(contour.radius[3], 11);
  contour.learn(3, 11, kRule);
  EXPECT_TRUE(contour.known(3, kRule));
  EXPECT_FALSE(contour.known(4, kRule));
  EXPECT_FLOAT_EQ(contour.residual(3, 13.5F), 2.5F);
}

TEST(Contour, ForgetsWithItsMemory) {
  Contour contour;
  for (int i = 0; i < 300; ++i) contour.learn(0, 10, kRule);
  EXPECT_EQ(contour.count[0], 16);
  contour.learn(0, 26, kRule);
  EXPECT_FLOAT_EQ(contour.radius[0], 11);
}

TEST(Contour, VarianceIsThatOfKnownDirectionsClipped) {
  Contour contour;
  for (int i = 0; i < 3; ++i) contour.learn(0, 10, kRule);
  EXPECT_EQ(contour.variance, Contour::kInitialVariance_px2);
  contour.learn(0, 1000, kRule);
  EXPECT_FLOAT_EQ(contour.variance, 4 + (25 - 4) / 64.0F);
  for (int i = 0; i < 1000; ++i) contour.learn(1, 8, kRule);
  EXPECT_LT(contour.variance, 1e-3F);
}

TEST(Contour, ForgettingKeepsTheVariance) {
  Contour contour;
  contour.centre_variance = 0.001F;
  for (int i = 0; i < 50; ++i) contour.learn(0, 10, kRule);
  const float variance = contour.variance;
  contour.forget_radius();
  EXPECT_FALSE(contour.known(0, kRule));
  EXPECT_EQ(contour.variance, variance);
  EXPECT_EQ(contour.centre_variance, Contour::kInitialCentreVariance);
  contour.learn(0, 4, kRule);
  EXPECT_FLOAT_EQ(contour.radius[0], 4);
}

}  // namespace
}  // namespace asap::fast::contour_test
