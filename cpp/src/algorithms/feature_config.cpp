#include "asap/algorithms/feature_config.hpp"

#include "asap/core/check.hpp"

namespace asap {

const FeatureConfig& checked(const FeatureConfig& config) {
  constexpr int kMaxSide = 16384;
  constexpr int kMaxWindow = 65535;  // tracks have numbers of 16 bits
  constexpr int kNeighbours = 8;
  constexpr std::int64_t kMaxVelocity_us = 1'000'000'000;

  const auto is_side = [](int value) { return 1 <= value && value <= kMaxSide; };
  require(is_side(config.width), "width", config.width, "must be 1 to 16384 px");
  require(is_side(config.height), "height", config.height, "must be 1 to 16384 px");
  require(1 <= config.window && config.window <= kMaxWindow, "window", config.window,
          "must be 1 to 65535 corner events");
  require(0 <= config.radius && config.radius <= kMaxSide, "radius", config.radius,
          "must be 0 to 16384 px");
  require(0 <= config.min_neighbours && config.min_neighbours < kNeighbours, "min_neighbours",
          config.min_neighbours, "must be 0 to 7");
  require(1 <= config.velocity_us && config.velocity_us <= kMaxVelocity_us, "velocity_us",
          config.velocity_us, "must be 1 to 1000000000 us");
  return config;
}

}  // namespace asap
