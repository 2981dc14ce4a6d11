#include "study/scenes/limb.hpp"

#include "core/check.hpp"

namespace asap {
namespace {

constexpr double kTwoPi = 6.283185307179586;

}  // namespace

Limb::Limb(const LimbConfig& config)
    : config_(config), shape_(ShapeKind::kBar, 0.5 * config.length_px, config.width_px) {
  require(config.swing_rad >= 0.0 && config.swing_rad <= 1.0, "swing_rad", config.swing_rad,
          "give 0 to 1 rad");
  require(config.rate_hz >= 0.0 && config.rate_hz <= 10.0, "rate_hz", config.rate_hz,
          "give 0 to 10 Hz");
}

Pose Limb::on(const Pose& shape) const noexcept {
  const UnitVector own = config_.direction.turned(0.5 * config_.swing_rad * config_.phase.y);
  const double half = 0.5 * config_.length_px;
  const double x = shape.scale * (config_.joint.x + half * own.x);
  const double y = shape.scale * (config_.joint.y + half * own.y);
  return {.position{shape.position.x + x * shape.axis.x - y * shape.axis.y,
                    shape.position.y + y * shape.axis.x + x * shape.axis.y},
          .velocity = shape.velocity,
          .axis{own.x * shape.axis.x - own.y * shape.axis.y,
                own.y * shape.axis.x + own.x * shape.axis.y},
          .scale = shape.scale};
}

void Limb::advance() noexcept {
  constexpr double kStep_s = 1e-6 * RigidMotion::kStep_us;
  config_.phase = config_.phase.turned(0.5 * kTwoPi * config_.rate_hz * kStep_s);
}

}  // namespace asap
