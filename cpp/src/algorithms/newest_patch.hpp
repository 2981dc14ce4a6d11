// NewestPatch: the 25 pixels of the 9 x 9 window around an event that fired last, as nine masks of
// nine bits. The bar that exactly 25 numbers reach is searched by counting, first where it was last
// time. One thread; no allocation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "algorithms/order_surface.hpp"

namespace asap::inline v0_1 {

// Bit x of rows[y] is the pixel at (x - 4, y - 4) from the centre.
using PatchRows = std::array<std::uint32_t, 9>;

class NewestPatch {
 public:
  static constexpr int kPixels = 25;

  // False, with `rows` void, if fewer than 25 pixels of the window have fired. `centre` is a pixel
  // of the frame and holds the newest number of its plane; no two numbers of a plane are equal.
  bool select(const OrderSurface::Number* centre, std::ptrdiff_t stride, PatchRows& rows) noexcept;

  void clear() noexcept { depth_ = kFirstDepth; }

 private:
  static constexpr OrderSurface::Number kFirstDepth = 1024;

  OrderSurface::Number depth_ = kFirstDepth;  // how far the last bar lay below the newest number
};

}  // namespace asap::inline v0_1
