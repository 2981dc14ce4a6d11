#include "algorithms/fast/decay.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace decay_test {
namespace {

using asap::fast::decay;
using asap::fast::low_pass_weight;

TEST(Decay, IsTheExponential) {
  EXPECT_EQ(decay(0), 1);
  for (float u = 0.001F; u < 30; u *= 1.1F) {
    EXPECT_NEAR(decay(u) / std::exp(-u), 1, u < 12 ? 2e-5 : 1e-3) << u;
  }
}

TEST(Decay, StaysPositiveAndFinite) {
  EXPECT_GT(decay(1e30F), 0);
  EXPECT_LT(decay(1e30F), 1e-30F);
}

TEST(Logarithm, IsTheNaturalOne) {
  for (float y = 0.5F; y < 1000; y *= 1.1F) {
    EXPECT_NEAR(asap::fast::logarithm(y), std::log(y), 1e-5) << y;
  }
  EXPECT_GT(asap::fast::logarithm(1e38F), 60);
}

TEST(LowPassWeight, IsTheMeanOverTheAgeAtFirst) {
  EXPECT_EQ(low_pass_weight(decay(0.1F), 1, 1), 1);
  EXPECT_EQ(low_pass_weight(decay(0.1F), 1, 2), 0.5F);
  EXPECT_EQ(low_pass_weight(decay(0.1F), 1, 1000), 1 - decay(0.1F));
}

}  // namespace
}  // namespace decay_test
