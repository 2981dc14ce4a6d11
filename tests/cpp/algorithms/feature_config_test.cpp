#include "asap/algorithms/feature_config.hpp"

#include <gtest/gtest.h>

#include "support/errors.hpp"

namespace feature_config_test {
namespace {

using asap::FeatureConfig;

std::string error_of(const FeatureConfig& config) {
  return asap::test::error_of([&] { asap::checked(config); });
}

TEST(FeatureConfig, NamesTheBadField) {
  EXPECT_EQ(error_of({.width = 0, .height = 10}), "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 16385}), "height = 16385: must be 1 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .window = 0}),
            "window = 0: must be 1 to 65535 corner events");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .window = 65536}),
            "window = 65536: must be 1 to 65535 corner events");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .radius = -1}),
            "radius = -1: must be 0 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .radius = 16385}),
            "radius = 16385: must be 0 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .min_neighbours = -1}),
            "min_neighbours = -1: must be 0 to 7");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .min_neighbours = 8}),
            "min_neighbours = 8: must be 0 to 7");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .velocity_us = 0}),
            "velocity_us = 0: must be 1 to 1000000000 us");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .velocity_us = 1'000'000'001}),
            "velocity_us = 1000000001: must be 1 to 1000000000 us");
}

TEST(FeatureConfig, TakesTheLimits) {
  EXPECT_NO_THROW(asap::checked(
      {.width = 1, .height = 1, .window = 1, .radius = 0, .min_neighbours = 0, .velocity_us = 1}));
  EXPECT_NO_THROW(asap::checked({.width = 16384,
                                 .height = 16384,
                                 .window = 65535,
                                 .radius = 16384,
                                 .min_neighbours = 7,
                                 .velocity_us = 1'000'000'000}));
}

}  // namespace
}  // namespace feature_config_test
