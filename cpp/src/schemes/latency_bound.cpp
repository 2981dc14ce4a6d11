#include "schemes/latency_bound.hpp"

#include <cmath>

#include "asap/core/check.hpp"

namespace asap {

std::int64_t checked_latency_ns(double latency_ms) {
  require(latency_ms >= 0.01 && latency_ms <= 1e7, "latency_ms", latency_ms,
          "must be between 0.01 and 1e7 ms");
  return std::llround(latency_ms * 1e6);
}

double checked_knee(double knee) {
  require(knee == 0 || (knee >= 1 && knee <= 1e6), "knee", knee,
          "must be 0 (off) or between 1 and 1e6");
  return knee;
}

double latency_ms(std::int64_t bound_ns, double configured_ms) noexcept {
  if (bound_ns == std::llround(configured_ms * 1e6)) return configured_ms;
  return static_cast<double>(bound_ns) / 1e6;
}

}  // namespace asap
