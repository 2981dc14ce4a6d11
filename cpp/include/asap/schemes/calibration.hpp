// Calibration: how far a cost model may be trusted that has not seen much (notebooks/theory.md,
// section 8).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "asap/schemes/scheme.hpp"

namespace asap {

// Whether package `index` (from 0) is one of the first: what was assumed may still be to blame.
constexpr bool is_early(std::uint64_t index) noexcept { return index < 15; }

// The largest size of a package that nothing ends, whatever the cost model says: as fixed costs are
// not negative, so many take time_ns even if all that packages have cost was the cost of their
// events. And one more, or else a fixed cost of most of the time would keep packages small for
// ever. Two are tried whatever they cost.
inline double safe_size(double time_ns, double most_event_ns) noexcept {
  return 1.0 + std::max(1.0, std::floor(time_ns / most_event_ns));
}

// A whole package that may take longer than there is time is cut to its head: nothing is discarded
// for what may be an error of the cost model.
inline Decision safe_slice(const Decision& planned, double safe) noexcept {
  if (planned.keep * static_cast<double>(planned.raw) <= safe) return planned;
  Decision slice = Decision::take(static_cast<std::size_t>(safe));
  slice.stale = planned.stale;
  return slice;
}

// Whether package `index` is a single event: a fixed cost that rules the bound out is believed only
// as long as that costs as much.
constexpr bool is_single(std::uint64_t index, double alpha_ns, double latency_ns) noexcept {
  return 4.0 * alpha_ns > latency_ns && !is_early(index) && index % 16 == 15;
}

}  // namespace asap
