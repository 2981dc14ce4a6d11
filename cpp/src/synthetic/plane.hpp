// PlanePoint and UnitVector: points and directions of the image plane.
#pragma once

namespace asap::inline v0_1 {

struct PlanePoint {
  double x;  // px
  double y;  // px, downwards
};

// A direction that turns without sin and cos, whose last bits differ between C libraries. Turning
// by the angle w goes by tan(w/2), the rational form of a rotation (Cayley): exactly rounded
// operations only, and the length stays 1.
struct UnitVector {
  double x = 1.0;
  double y = 0.0;

  // half_tangent of a small angle is half the angle in rad (0.3 % short at 0.2 rad).
  UnitVector turned(double half_tangent) const noexcept {
    const double square = half_tangent * half_tangent;
    const double cosine = (1.0 - square) / (1.0 + square);
    const double sine = 2.0 * half_tangent / (1.0 + square);
    return {x * cosine - y * sine, x * sine + y * cosine};
  }
};

}  // namespace asap::inline v0_1
