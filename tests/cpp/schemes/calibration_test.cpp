#include "schemes/calibration.hpp"

#include <gtest/gtest.h>

namespace asap::calibration_test {
namespace {

TEST(Calibration, WhatIsNotSafeWaits) {
  Decision planned = Decision::take(1000, 0.5);
  planned.stale = 7;
  EXPECT_EQ(safe_slice(planned, 500).keep, 0.5);
  const Decision slice = safe_slice(planned, 499);
  EXPECT_EQ(slice.raw, 499u);
  EXPECT_EQ(slice.keep, 1.0);
  EXPECT_EQ(slice.stale, 7u);
}

}  // namespace
}  // namespace asap::calibration_test
