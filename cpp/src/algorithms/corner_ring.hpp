// CornerRing: the values of an OrderSurface on a circle of 16 or 20 pixels around an event, and
// what corner rules ask of it: which pixel is the newest, which are at least as new as a bar, which
// neighbour an arc grows to. Pixels are sorted by angle; masks hold pixel i in bit i. One thread;
// no allocation; a dozen vector instructions where there is SSE2, and a loop with the same results.
// Source: Mueggler et al., "Fast Event-based Corner Detection", BMVC 2017.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "algorithms/int4.hpp"
#include "algorithms/order_surface.hpp"

namespace asap::inline v0_1 {

struct RingPixel {
  int dx;
  int dy;
};

inline constexpr std::array<RingPixel, 16> kRing3{{{0, 3},
                                                   {1, 3},
                                                   {2, 2},
                                                   {3, 1},
                                                   {3, 0},
                                                   {3, -1},
                                                   {2, -2},
                                                   {1, -3},
                                                   {0, -3},
                                                   {-1, -3},
                                                   {-2, -2},
                                                   {-3, -1},
                                                   {-3, 0},
                                                   {-3, 1},
                                                   {-2, 2},
                                                   {-1, 3}}};

inline constexpr std::array<RingPixel, 20> kRing4{
    {{0, 4},  {1, 4},   {2, 3},   {3, 2},   {4, 1},   {4, 0},  {4, -1}, {3, -2}, {2, -3}, {1, -4},
     {0, -4}, {-1, -4}, {-2, -3}, {-3, -2}, {-4, -1}, {-4, 0}, {-4, 1}, {-3, 2}, {-2, 3}, {-1, 4}}};

// Pixels that must lie between an event and the border for both rings to exist.
inline constexpr std::uint32_t kRingMargin = 4;

template <const auto& kPixels>
class CornerRing {
 public:
  using Number = OrderSurface::Number;
  static constexpr int kSize = static_cast<int>(kPixels.size());

  CornerRing(const Number* centre, std::ptrdiff_t stride) noexcept {
    const auto value = [&](std::size_t i) {
      return centre[kPixels[i].dy * stride + kPixels[i].dx];
    };
    for (std::size_t i = 0; i < kPixels.size(); i += 4) {
      const Int4::Lanes four = Int4::of(value(i), value(i + 1), value(i + 2), value(i + 3));
      Int4::store(four, &values_[i]);
    }
  }

  Number operator[](int i) const noexcept { return values_[static_cast<std::size_t>(i)]; }

  static int after(int i) noexcept { return i + 1 == kSize ? 0 : i + 1; }
  static int before(int i) noexcept { return i == 0 ? kSize - 1 : i - 1; }

  // The first pixel of the newest.
  int newest() const noexcept {
    Int4::Lanes largest = Int4::load(&values_[0]);
    for (std::size_t i = 4; i < kPixels.size(); i += 4) {
      largest = Int4::max(largest, Int4::load(&values_[i]));
    }
    // The last pixel is named so that the compiler sees an index in range.
    return std::countr_zero(at_least(Int4::largest(largest)) | 1U << (kSize - 1));
  }

  std::uint32_t at_least(Number bar) const noexcept {
    std::uint32_t mask = 0;
    for (std::size_t i = 0; i < kPixels.size(); i += 4) {
      mask |= Int4::mask_above(Int4::load(&values_[i]), bar - 1) << i;
    }
    return mask;
  }

 private:
  alignas(16) std::array<Number, kPixels.size()> values_;
};

// Consecutive pixels of a ring, grown from the newest towards the newer neighbour.
template <class Ring>
class GrowingArc {
 public:
  using Number = OrderSurface::Number;

  explicit GrowingArc(const Ring& ring) noexcept : ring_(ring) {
    const int newest = ring.newest();
    oldest_ = ring[newest];
    before_ = Ring::before(newest);
    after_ = Ring::after(newest);
  }

  void grow_to(int length) noexcept {
    for (; length_ < length; ++length_) {
      const Number forwards = ring_[after_];
      const Number backwards = ring_[before_];
      oldest_ = std::min(oldest_, std::max(forwards, backwards));
      // A branch would be mispredicted, so there is none.
      after_ = forwards > backwards ? Ring::after(after_) : after_;
      before_ = forwards > backwards ? before_ : Ring::before(before_);
    }
  }

  int length() const noexcept { return length_; }
  Number oldest() const noexcept { return oldest_; }

  // The first pixel behind the arc, forwards.
  int after() const noexcept { return after_; }

 private:
  const Ring& ring_;
  Number oldest_;
  int before_;
  int after_;
  int length_ = 1;
};

}  // namespace asap::inline v0_1
