#include "asap/algorithms/compat_cluster_config.hpp"

#include <cmath>

#include "asap/core/check.hpp"

namespace asap {

const CompatClusterConfig& checked(const CompatClusterConfig& config) {
  constexpr int kMaxSide = 65536;    // pixel coordinates are 16 bits
  constexpr int kMaxWindow = 65535;  // window positions are 16 bits

  const auto is_side = [](int value) { return 1 <= value && value <= kMaxSide; };
  require(is_side(config.width), "width", config.width, "must be 1 to 65536 px");
  require(is_side(config.height), "height", config.height, "must be 1 to 65536 px");
  require(1 <= config.window && config.window <= kMaxWindow, "window", config.window,
          "must be 1 to 65535 events");
  require(std::isfinite(config.radius) && config.radius >= 0, "radius", config.radius,
          "must be finite and at least 0 px");
  require(config.probes >= 0, "probes", config.probes, "must be at least 0");
  require(0 <= config.weight && config.weight <= 1, "weight", config.weight, "must be in [0, 1]");
  require(config.min_size >= 0, "min_size", config.min_size, "must be at least 0 events");
  return config;
}

}  // namespace asap
