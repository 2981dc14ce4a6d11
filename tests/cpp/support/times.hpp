// Times of a test.
#pragma once

#include <chrono>
#include <cmath>

namespace asap::test {

inline std::chrono::nanoseconds ms(double value) {
  return std::chrono::nanoseconds(std::llround(value * 1e6));
}

}  // namespace asap::test
