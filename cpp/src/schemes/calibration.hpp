// Calibration: rules for a cost model that has not seen enough packages yet (notebooks/theory.md,
// section 8).
#pragma once

#include <cstddef>
#include <cstdint>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

// Whether package `index` (from 0) is one of the first, whose cost may still be a wrong assumption.
constexpr bool is_early(std::uint64_t index) noexcept { return index < 15; }

// Cuts a package that is larger than is safe to its oldest events. The rest waits: an error of the
// cost model must not discard events.
inline Decision safe_slice(const Decision& planned, double safe) noexcept {
  if (planned.gamma * static_cast<double>(planned.raw) <= safe) return planned;
  Decision slice = Decision::take(static_cast<std::size_t>(safe));
  slice.stale = planned.stale;
  return slice;
}

}  // namespace asap::inline v0_1
