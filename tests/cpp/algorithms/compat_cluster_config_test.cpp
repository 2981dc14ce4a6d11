#include "asap/algorithms/compat_cluster_config.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace compat_cluster_config_test {
namespace {

using asap::CompatClusterConfig;

std::string complaint(const std::function<void(CompatClusterConfig&)>& spoil) {
  CompatClusterConfig config{.width = 346, .height = 260};
  spoil(config);
  try {
    asap::checked(config);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

TEST(CompatClusterConfig, DefaultsAreTheLaunchValues) {
  const CompatClusterConfig config{.width = 346, .height = 260};
  EXPECT_EQ(config.window, 800);
  EXPECT_EQ(config.radius, 20);
  EXPECT_EQ(config.probes, 1);
  EXPECT_EQ(config.weight, 0.9);
  EXPECT_EQ(config.min_size, 15);
  EXPECT_EQ(config.motion, asap::CompatMotion::kWindow);
  EXPECT_EQ(&asap::checked(config), &config);
}

TEST(CompatClusterConfig, ErrorsNameFieldValueAndRemedy) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(complaint([](auto& c) { c.width = 0; }), "width = 0: must be 1 to 65536 px");
  EXPECT_EQ(complaint([](auto& c) { c.height = 65537; }), "height = 65537: must be 1 to 65536 px");
  EXPECT_EQ(complaint([](auto& c) { c.window = 0; }), "window = 0: must be 1 to 65535 events");
  EXPECT_EQ(complaint([](auto& c) { c.window = 65536; }),
            "window = 65536: must be 1 to 65535 events");
  EXPECT_EQ(complaint([](auto& c) { c.radius = -1; }),
            "radius = -1: must be finite and at least 0 px");
  EXPECT_NE(complaint([](auto& c) { c.radius = kNan; }), "none");
  EXPECT_NE(complaint([](auto& c) { c.radius = kInfinity; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.probes = -1; }), "probes = -1: must be at least 0");
  EXPECT_EQ(complaint([](auto& c) { c.weight = 1.5; }), "weight = 1.5: must be in [0, 1]");
  EXPECT_EQ(complaint([](auto& c) { c.weight = -0.5; }), "weight = -0.5: must be in [0, 1]");
  EXPECT_NE(complaint([](auto& c) { c.weight = kNan; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.min_size = -1; }),
            "min_size = -1: must be at least 0 events");
}

TEST(CompatClusterConfig, LimitsAreAllowed) {
  EXPECT_EQ(complaint([](auto& c) { c.width = 65536; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.window = 65535; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.radius = 0; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.weight = 0; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.weight = 1; }), "none");
  EXPECT_EQ(complaint([](auto& c) { c.min_size = 0; }), "none");
}

}  // namespace
}  // namespace compat_cluster_config_test
