#include "asap/runner/run_config.hpp"

#include <algorithm>
#include <bit>

#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kHighestRate = 60e6;  // events per second that a sensor is known to deliver
constexpr std::size_t kMinCapacity = std::size_t{1} << 20;

}  // namespace

std::int64_t latency_bound_ns(const RunConfig& config, const Scheme& scheme) {
  const std::int64_t own_ns = scheme.latency_bound_ns();
  if (!config.latency) return own_ns > 0 ? own_ns : kDefaultLatency.count();
  const std::int64_t wanted_ns = checked_latency_ns(*config.latency);
  require_time(own_ns == 0 || own_ns == wanted_ns, "latency", *config.latency, TimeUnit::ms,
               "differs from the bound of the scheme; give one of the two");
  return wanted_ns;
}

std::size_t ring_capacity(const RunConfig& config, std::int64_t latency_bound_ns) noexcept {
  if (config.capacity > 0) return config.capacity;
  const double events = kHighestRate * 2.0 * static_cast<double>(latency_bound_ns) * 1e-9;
  // A bound of minutes must not ask for gigabytes.
  return std::bit_ceil(
      std::clamp(static_cast<std::size_t>(events), kMinCapacity, 64 * kMinCapacity));
}

}  // namespace asap::inline v0_1
