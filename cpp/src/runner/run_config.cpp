#include "asap/runner/run_config.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr std::int64_t kDefaultLatencyNs = 10'000'000;
constexpr double kHighestRate = 60e6;  // events per second that a sensor is known to deliver
constexpr std::size_t kLeastCapacity = std::size_t{1} << 20;

}  // namespace

std::int64_t checked_latency_bound_ns(double latency_us) {
  require(latency_us >= 10 && latency_us <= 1e10, "latency_us", latency_us,
          "must be between 10 and 1e10 us");
  return std::llround(latency_us * 1e3);
}

std::int64_t latency_bound_ns(const RunConfig& config, const Scheme& scheme) {
  const std::int64_t own_ns = scheme.latency_bound_ns();
  if (!config.latency_us) return own_ns > 0 ? own_ns : kDefaultLatencyNs;
  const std::int64_t wanted_ns = checked_latency_bound_ns(*config.latency_us);
  // One number in ms and in us may be rounded to two.
  require(own_ns == 0 || std::abs(own_ns - wanted_ns) <= 1, "latency_us", *config.latency_us,
          "differs from the bound of the scheme; give one of the two");
  return own_ns == 0 ? wanted_ns : own_ns;
}

std::size_t ring_capacity(const RunConfig& config, std::int64_t latency_bound_ns) noexcept {
  if (config.capacity > 0) return config.capacity;
  const double events = kHighestRate * 2.0 * static_cast<double>(latency_bound_ns) * 1e-9;
  // A bound of minutes must not ask for gigabytes.
  return std::bit_ceil(
      std::clamp(static_cast<std::size_t>(events), kLeastCapacity, 64 * kLeastCapacity));
}

}  // namespace asap
