// Calibration: the sizes that show a cost model what it cannot see in steady state (notebooks/
// theory.md, section 8). The first packages double in size, which also keeps a wrong first guess
// harmless; later, while events are discarded, every 16th package is half as large.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace asap {

// Whether package `index` (from 0) belongs to the slow start.
constexpr bool is_early(std::uint64_t index) noexcept { return index < 15; }

// The largest size of package `index`: 2, 4, 8 ... 32768, then any.
constexpr double slow_start_size(std::uint64_t index) noexcept {
  if (!is_early(index)) return std::numeric_limits<double>::infinity();
  return static_cast<double>(std::uint64_t{2} << index);
}

// Of a package that nothing ends, while little is known: the bound holds even if all of its cost is
// that of its events. Two are tried whatever they cost.
inline double safe_size(double budget_ns, double most_event_ns) noexcept {
  return std::max(slow_start_size(0), std::floor(budget_ns / most_event_ns));
}

constexpr bool is_dithered(std::uint64_t index) noexcept {
  return !is_early(index) && index % 16 == 15;
}

// Whether package `index` is a single event: a fixed cost that rules the bound out is believed only
// as long as that costs as much.
constexpr bool is_single(std::uint64_t index, double alpha_ns, double latency_ns) noexcept {
  return 4.0 * alpha_ns > latency_ns && is_dithered(index);
}

}  // namespace asap
