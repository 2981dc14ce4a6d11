// NewestPatch: the 25 pixels of the 9 x 9 window around an event that fired last, as nine masks of
// nine bits. The bar that exactly 25 numbers reach is searched by counting, first where it was last
// time; with AVX2, where the machine has it, at three bars at a time. One thread; no allocation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "algorithms/order_surface.hpp"

namespace asap {

// Bit x of rows[y] is the pixel at (x - 4, y - 4) from the centre.
using PatchRows = std::array<std::uint32_t, 9>;

class NewestPatch {
 public:
  static constexpr int kPixels = 25;

  enum class Path : std::uint8_t { fastest, portable };

  // The same patches on every path; the fastest one that this machine has, or the one for all.
  explicit NewestPatch(Path path = Path::fastest) noexcept;

  // False, with `rows` void, if fewer than 25 pixels of the window have fired. `centre` is a pixel
  // of the frame and holds the newest number of its plane; no two numbers of a plane are equal.
  bool select(const OrderSurface::Number* centre, std::ptrdiff_t stride, PatchRows& rows) noexcept;

  void clear() noexcept { depth_ = kFirstDepth; }

 private:
  static constexpr OrderSurface::Number kFirstDepth = 1024;

  bool search(const OrderSurface::Number* centre, std::ptrdiff_t stride, PatchRows& rows) noexcept;

  bool avx2_;
  OrderSurface::Number depth_ = kFirstDepth;  // how far the last bar lay below the newest number
};

// The search on machines with AVX2: ages of 16 bits, eighty of them in five registers, counted
// against three bars at a time. Where 16 bits do not tell the 25th pixel from the next one, it says
// so and the search of NewestPatch decides.
enum class PatchSearch : std::uint8_t { found, too_few, unresolved };

// Whether this machine can run it.
bool has_avx2() noexcept;

// Precondition: has_avx2(), and that of NewestPatch::select. `depth` is how far the last bar lay
// below the newest number, and changed where one is found.
PatchSearch select_avx2(const OrderSurface::Number* centre, std::ptrdiff_t stride,
                        OrderSurface::Number& depth, PatchRows& rows) noexcept;

}  // namespace asap
