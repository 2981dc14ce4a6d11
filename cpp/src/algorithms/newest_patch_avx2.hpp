// select_avx2: the search of NewestPatch on machines with AVX2: ages of 16 bits, eighty of them in
// five registers, counted against three bars at a time. Where 16 bits do not tell the 25th pixel
// from the next one, it says so and the search of NewestPatch decides. One thread; no allocation.
#pragma once

#include <cstddef>
#include <cstdint>

#include "algorithms/newest_patch.hpp"

namespace asap {

enum class PatchSearch : std::uint8_t { found, too_few, unresolved };

// Whether this machine can run it.
bool has_avx2() noexcept;

// Precondition: has_avx2(), and that of NewestPatch::select. `depth` is how far the last bar lay
// below the newest number, and changed where one is found.
PatchSearch select_avx2(const OrderSurface::Number* centre, std::ptrdiff_t stride,
                        OrderSurface::Number& depth, PatchRows& rows) noexcept;

}  // namespace asap
