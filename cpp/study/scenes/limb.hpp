// Limb: a bar that is joined to a moving shape and waves to and fro about its joint, as a finger on
// a hand. Its events are the shape's. One thread, O(1) per step, no allocation; + - * / only (see
// event_stream.hpp).
#pragma once

#include <cstdint>

#include "study/scenes/rigid_motion.hpp"
#include "study/scenes/rigid_shape.hpp"

namespace asap {

struct LimbConfig {
  double length_px = 30.0;
  double width_px = 8.0;
  PlanePoint joint{};      // px, in the frame of the shape
  UnitVector direction{};  // at rest, from the joint to the tip
  double swing_rad = 0.0;  // to either side
  double rate_hz = 0.0;    // of the waves
  UnitVector phase{};      // at the start; y is the part of the swing
};

class Limb {
 public:
  explicit Limb(const LimbConfig& config);

  const RigidShape& shape() const noexcept { return shape_; }

  // Where the bar is while its shape is there.
  Pose on(const Pose& shape) const noexcept;

  void advance() noexcept;  // by one step of RigidMotion

 private:
  LimbConfig config_;
  RigidShape shape_;
};

}  // namespace asap
