#include "study/scenes/fence.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"

namespace asap {

Fence::Fence(const FenceConfig& config, std::int32_t width, std::int32_t height)
    : brightness_(config.brightness) {
  require(config.wire_px >= 1.0 && config.wire_px < config.pitch_px && config.pitch_px <= 1000.0,
          "wire_px", config.wire_px, "give 1 px or more, and less than a pitch of at most 1000 px");
  require(config.brightness >= 0.02 && config.brightness <= 1.0, "brightness", config.brightness,
          "give 0.02 to 1");
  hidden_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      double hidden = 0.0;
      for (const UnitVector& across : config.across) {
        const double wires = (x * across.x + y * across.y) / config.pitch_px;
        const double from_wire_px = config.pitch_px * std::abs(wires - std::floor(wires + 0.5));
        hidden = std::max(hidden, std::clamp(0.5 + 0.5 * config.wire_px - from_wire_px, 0.0, 1.0));
      }
      hidden_.push_back(hidden);
    }
  }
}

}  // namespace asap
