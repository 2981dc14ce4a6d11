// UnitVector: a direction that turns without sin and cos, whose last bits differ between C
// libraries. Turning by the angle w goes by tan(w/2), the rational form of a rotation (Cayley):
// exactly rounded operations only, and the length stays 1.
#pragma once

namespace asap {

struct UnitVector {
  double x = 1.0;
  double y = 0.0;

  // For small angles half_tangent is half the angle in rad (0.3 % short at 0.2 rad).
  UnitVector turned(double half_tangent) const noexcept;
};

}  // namespace asap
