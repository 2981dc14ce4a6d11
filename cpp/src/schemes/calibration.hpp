// Calibration: rules for a cost model that has not seen enough packages yet (notebooks/theory.md,
// section 8).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "asap/schemes/scheme.hpp"

namespace asap {

// Whether package `index` (from 0) is one of the first, whose cost may still be a wrong assumption.
constexpr bool is_early(std::uint64_t index) noexcept { return index < 15; }

// The largest whole package that ends within time_ns even if the cost model is wrong. Fixed costs
// are not negative, so n events take at most n times what an event of a smaller package has cost,
// its share of the fixed cost included. One event is added: without it a fixed cost close to
// time_ns would keep packages small for ever. The result is 2 or more, whatever events cost.
inline double safe_size(double time_ns, double most_event_ns) noexcept {
  return 1.0 + std::max(1.0, std::floor(time_ns / most_event_ns));
}

// Cuts a package that is larger than is safe to its oldest events. The rest waits: an error of the
// cost model must not discard events.
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
