// exp from + - * / alone, the same bits everywhere: C libraries differ in the last one.
#pragma once

#include <cmath>
#include <cstdint>

namespace asap::synthetic {

// For |x| up to 700; relative error below 1e-15.
inline double portable_exp(double x) noexcept {
  constexpr double kLog2E = 1.4426950408889634;
  constexpr double kLn2High = 6.93147180369123816490e-01;  // few bits: its multiples are exact
  constexpr double kLn2Low = 1.90821492927058770002e-10;
  constexpr int kTerms = 14;
  const auto doublings = static_cast<int>(x * kLog2E + (x < 0.0 ? -0.5 : 0.5));
  const double rest = (x - doublings * kLn2High) - doublings * kLn2Low;
  double sum = 1.0;
  for (int term = kTerms; term > 0; --term) sum = 1.0 + sum * rest / term;
  return std::ldexp(sum, doublings);
}

}  // namespace asap::synthetic
