// What a scheme is told of packages that cost alpha + beta n.
#pragma once

#include <cmath>
#include <cstddef>

#include "asap/schemes/scheme.hpp"

namespace asap::test {

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
