#include "study/mass_decay.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace asap::mass_decay_test {
namespace {

TEST(MassDecay, IsTheExponential) {
  EXPECT_EQ(mass_decay(0), 1.0F);
  for (float u = 0; u < 0.25F; u += 0.01F) EXPECT_NEAR(mass_decay(u) / std::exp(-u), 1, 0.004) << u;
  for (float u = 0.25F; u < 10; u += 0.1F) EXPECT_NEAR(mass_decay(u) / std::exp(-u), 1, 1e-4) << u;
}

TEST(MassDecay, TakesTheSeriesForShortTimes) {
  EXPECT_EQ(mass_decay(0.125F), 1 - 0.125F + 0.0078125F);
}

}  // namespace
}  // namespace asap::mass_decay_test
