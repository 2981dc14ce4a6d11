// log from + - * / alone, the same bits everywhere: C libraries differ in the last one.
#pragma once

#include <cmath>

namespace asap::synthetic {

// For x > 0; error below 1e-10.
inline double portable_log(double x) noexcept {
  constexpr double kLn2 = 0.69314718055994531;
  constexpr double kHalfRoot = 0.70710678118654752;
  int doublings = 0;
  double mantissa = std::frexp(x, &doublings);  // in [0.5, 1)
  if (mantissa < kHalfRoot) {
    mantissa *= 2.0;
    --doublings;
  }
  // log m = 2 artanh((m - 1) / (m + 1)), of an argument within 0.172.
  const double ratio = (mantissa - 1.0) / (mantissa + 1.0);
  const double square = ratio * ratio;
  double sum = 1.0 / 11.0;
  sum = sum * square + 1.0 / 9.0;
  sum = sum * square + 1.0 / 7.0;
  sum = sum * square + 1.0 / 5.0;
  sum = sum * square + 1.0 / 3.0;
  sum = sum * square + 1.0;
  return doublings * kLn2 + 2.0 * ratio * sum;
}

}  // namespace asap::synthetic
