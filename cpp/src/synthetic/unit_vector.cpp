#include "synthetic/unit_vector.hpp"

namespace asap {

UnitVector UnitVector::turned(double half_tangent) const noexcept {
  const double square = half_tangent * half_tangent;
  const double cosine = (1.0 - square) / (1.0 + square);
  const double sine = 2.0 * half_tangent / (1.0 + square);
  return {x * cosine - y * sine, x * sine + y * cosine};
}

}  // namespace asap
