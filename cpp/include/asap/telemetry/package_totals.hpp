// PackageTotals: what all packages of a run come to, exactly, also when the log keeps only the
// newest rows. One thread adds; a copy may be taken by any thread meanwhile.
#pragma once

#include <algorithm>
#include <cstdint>

#include "asap/core/atomics.hpp"

namespace asap {

struct PackageTotals {
  Relaxed<std::uint64_t> count;    // packages
  Relaxed<std::uint64_t> thinned;  // events that came to the gamma filter
  Relaxed<std::uint64_t> size;     // events kept
  Relaxed<std::uint64_t> size_max;
  Relaxed<std::int64_t> processing_ns;
  Relaxed<double> gamma_min = 1.0;

  void add(std::uint64_t package_thinned, std::uint64_t package_size,
           std::int64_t package_processing_ns) noexcept {
    ++count;
    thinned += package_thinned;
    size += package_size;
    size_max = std::max(size_max.load(), package_size);
    processing_ns += package_processing_ns;
    const double gamma = static_cast<double>(package_size) / static_cast<double>(package_thinned);
    gamma_min = std::min(gamma_min.load(), gamma);
  }
};

}  // namespace asap
