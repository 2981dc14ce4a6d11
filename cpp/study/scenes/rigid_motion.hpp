// RigidMotion: where a moving object is after each step: straight ahead with bounces off a box, or
// round an orbit, turning at a constant rate, with one pause at will, and coming nearer. The
// velocity is that of the step that follows, so that it is the derivative of the position (but for
// the step of a bounce). One thread, O(1) per step, no allocation; + - * / only (see
// event_stream.hpp).
#pragma once

#include <cstdint>
#include <variant>

#include "synthetic/plane.hpp"

namespace asap {

struct Bounce {
  PlanePoint start{};     // px, inside the box
  PlanePoint velocity{};  // px/s
  PlanePoint low{};       // corner of the box in which the centre stays
  PlanePoint high{};
};

struct Orbit {
  PlanePoint centre{};
  double radius_px = 14.0;
  double speed_px_s = 90.0;  // negative: the other way round
  UnitVector phase{};        // from the centre, at the start
};

struct Pause {
  std::int64_t from_us = 0;
  std::int64_t to_us = 0;  // equal: none
};

// Coming nearer at a constant speed: the size goes with 1 / distance, up to this factor.
struct Growth {
  double factor = 1.0;
  std::int64_t duration_us = 1;
};

struct RigidMotionConfig {
  std::variant<Bounce, Orbit> path{};
  UnitVector axis{};        // direction of the shape's x axis at the start
  double spin_rad_s = 0.0;  // from x towards y
  Pause pause{};
  Growth growth{};
};

struct Pose {
  PlanePoint position;    // px
  PlanePoint velocity{};  // px/s
  UnitVector axis;
  double scale = 1.0;  // of the size at the start
};

class RigidMotion {
 public:
  static constexpr std::int32_t kStep_us = 250;
  static constexpr double kMaxSpeed_px_s = 2000.0;

  explicit RigidMotion(const RigidMotionConfig& config);

  const Pose& pose() const noexcept { return pose_; }

  void advance() noexcept;  // by one step

 private:
  bool pausing() const noexcept;
  void place() noexcept;

  RigidMotionConfig config_;
  Pose pose_{};
  std::int64_t elapsed_us_ = 0;
};

}  // namespace asap
