// What a scheme is told of packages that cost alpha + beta n.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "asap/schemes/scheme.hpp"

namespace asap::test {

// A package of one part: its work took that long.
inline Outcome package(std::size_t size, double work_ns) {
  return {.size = size,
          .raw = size,
          .span_ns = 0,
          .start_ns = 0,
          .processing_ns = static_cast<std::int64_t>(std::clamp(work_ns, -9e18, 9e18))};
}

// An anytime package of several parts; the fixed cost is in the first one.
inline Outcome in_parts(std::size_t size, std::size_t first_size, double alpha_ns, double beta_ns) {
  return {
      .size = size,
      .raw = size,
      .span_ns = 0,
      .start_ns = 0,
      .processing_ns = std::llround(alpha_ns + beta_ns * static_cast<double>(size)),
      .first_size = first_size,
      .first_ns = std::llround(alpha_ns + beta_ns * static_cast<double>(first_size)),
  };
}

}  // namespace asap::test
