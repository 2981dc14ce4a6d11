#include "schemes/latency_bound.hpp"

#include <cmath>

#include "asap/core/check.hpp"

namespace asap {

std::int64_t checked_latency_ns(double latency_ms) {
  require(latency_ms >= 0.01 && latency_ms <= 1e7, "latency_ms", latency_ms,
          "must be between 0.01 and 1e7 ms");
  return std::llround(latency_ms * 1e6);
}

}  // namespace asap
