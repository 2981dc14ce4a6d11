#include "study/scenes/rigid_motion.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"

namespace asap {
namespace {

constexpr double kStep_s = 1e-6 * RigidMotion::kStep_us;
constexpr double kFarthest_px = 1e5;

bool inside(double value, double low, double high) noexcept {
  return value >= low && value <= high;
}

void check(const Bounce& path) {
  const double square = path.velocity.x * path.velocity.x + path.velocity.y * path.velocity.y;
  constexpr double kMax = RigidMotion::kMaxSpeed_px_s;
  require(square <= kMax * kMax, "speed_px_s", std::sqrt(square), "give at most 2000 px/s");
  for (const double end : {path.low.x, path.low.y, path.high.x, path.high.y}) {
    require(std::abs(end) <= kFarthest_px, "box", end, "give a box within 1e5 px of the sensor");
  }
  require(inside(path.start.x, path.low.x, path.high.x), "start.x", path.start.x,
          "start inside the box of the bounces");
  require(inside(path.start.y, path.low.y, path.high.y), "start.y", path.start.y,
          "start inside the box of the bounces");
}

void check(const Orbit& path) {
  for (const double place : {path.centre.x, path.centre.y}) {
    require(std::abs(place) <= kFarthest_px, "centre", place, "give a centre within 1e5 px");
  }
  require(path.radius_px >= 1.0 && path.radius_px <= 1e4, "radius_px", path.radius_px,
          "give an orbit of 1 to 10000 px");
  require(std::abs(path.speed_px_s) <= RigidMotion::kMaxSpeed_px_s, "speed_px_s", path.speed_px_s,
          "give at most 2000 px/s");
}

void bounce(double& position, double& velocity, double low, double high) noexcept {
  position += velocity * kStep_s;
  if (position < low) {
    position = 2.0 * low - position;
    velocity = -velocity;
  } else if (position > high) {
    position = 2.0 * high - position;
    velocity = -velocity;
  }
}

void advance(Bounce& path) noexcept {
  bounce(path.start.x, path.velocity.x, path.low.x, path.high.x);
  bounce(path.start.y, path.velocity.y, path.low.y, path.high.y);
}

void advance(Orbit& path) noexcept {
  path.phase = path.phase.turned(0.5 * kStep_s * path.speed_px_s / path.radius_px);
}

Pose pose_on(const Bounce& path) noexcept { return {path.start, path.velocity, {}}; }

Pose pose_on(const Orbit& path) noexcept {
  return {{path.centre.x + path.radius_px * path.phase.x,
           path.centre.y + path.radius_px * path.phase.y},
          {-path.speed_px_s * path.phase.y, path.speed_px_s * path.phase.x},
          {}};
}

}  // namespace

RigidMotion::RigidMotion(const RigidMotionConfig& config) : config_(config) {
  std::visit([](const auto& path) { check(path); }, config.path);
  require(std::abs(config.spin_rad_s) <= 100.0, "spin_rad_s", config.spin_rad_s,
          "give -100 to 100 rad/s");
  require(config.pause.from_us <= config.pause.to_us, "pause.to_us", config.pause.to_us,
          "end the pause after its start");
  require(config.growth.factor >= 1.0 && config.growth.factor <= 100.0, "growth.factor",
          config.growth.factor, "give 1 to 100");
  require(config.growth.duration_us >= 1, "growth.duration_us", config.growth.duration_us,
          "give 1 us or more");
  place();
}

void RigidMotion::advance() noexcept {
  if (!pausing()) {
    std::visit([](auto& path) { asap::advance(path); }, config_.path);
    config_.axis = config_.axis.turned(0.5 * kStep_s * config_.spin_rad_s);
  }
  elapsed_us_ += kStep_us;
  place();
}

bool RigidMotion::pausing() const noexcept {
  return elapsed_us_ >= config_.pause.from_us && elapsed_us_ < config_.pause.to_us;
}

void RigidMotion::place() noexcept {
  pose_ = std::visit([](const auto& path) { return pose_on(path); }, config_.path);
  pose_.axis = config_.axis;
  const auto [factor, duration_us] = config_.growth;
  const double share =
      static_cast<double>(std::min(elapsed_us_, duration_us)) / static_cast<double>(duration_us);
  pose_.scale = 1.0 / (1.0 - (1.0 - 1.0 / factor) * share);
  if (pausing()) pose_.velocity = {0.0, 0.0};
}

}  // namespace asap
