// arc_length: the length of the newest arc of a ring as Arc* measures it: pixels are taken on the
// newer of both sides until the ring is closed; the length is how many were taken when the arc last
// grew. The first `shortest` belong to it in any case, a later one if it is as new as the oldest of
// the arc; with it the arc takes in all that were passed over on its side. The pixels in between
// are taken in one step. Pure function.
// Source: Alzugaray, Chli, "Asynchronous Corner Detection and Tracking for Event Cameras in Real
// Time", RA-L 2018.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "algorithms/corner_ring.hpp"

namespace asap::inline v0_1 {

template <class Ring>
int arc_length(const Ring& ring, int shortest) noexcept {
  using Number = OrderSurface::Number;
  constexpr int kSize = Ring::kSize;
  constexpr Number kNone = std::numeric_limits<Number>::max();
  const auto wrapped = [](int i) { return i >= kSize ? i - kSize : i; };

  GrowingArc arc(ring);
  arc.grow_to(shortest);
  int length = shortest;
  int first = arc.after();      // the first pixel that is left, forwards
  int left = kSize - shortest;  // how many these are
  Number oldest = arc.oldest();
  Number passed_forwards = kNone;  // oldest that was passed over on this side
  Number passed_backwards = kNone;

  while (true) {
    // The pixels among those left that are as new as the arc; bit i is pixel first + i.
    const std::uint32_t newer = ring.at_least(oldest);
    std::uint32_t queue = ((newer >> first) | (newer << (kSize - first))) & ((1U << left) - 1);
    if (queue == 0) return length;

    const int forwards = std::countr_one(queue);
    queue >>= forwards;
    first = wrapped(first + forwards);
    left -= forwards;
    const int backwards = queue == 0 ? 0 : std::countl_one(queue << (32 - left));
    left -= backwards;
    if (forwards + backwards > 0) {
      if (forwards > 0) oldest = std::min(oldest, passed_forwards);
      if (backwards > 0) oldest = std::min(oldest, passed_backwards);
      length = kSize - left;
      continue;
    }

    do {
      const int last = wrapped(first + left - 1);
      if (ring[first] > ring[last]) {
        passed_forwards = std::min(passed_forwards, ring[first]);
        first = Ring::after(first);
        queue >>= 1;
      } else {
        passed_backwards = std::min(passed_backwards, ring[last]);
      }
      --left;
    } while ((queue & 1) == 0 && (queue >> (left - 1)) == 0);
  }
}

// The test of Arc*: an arc that is short, or whose rest is, on both circles.
inline bool has_corner_arcs(const OrderSurface::Number* centre, std::ptrdiff_t stride) noexcept {
  const int inner = arc_length(CornerRing<kRing3>(centre, stride), 3);
  if (!(inner <= 6 || (10 <= inner && inner <= 13))) return false;
  const int outer = arc_length(CornerRing<kRing4>(centre, stride), 4);
  return outer <= 8 || (12 <= outer && outer <= 16);
}

}  // namespace asap::inline v0_1
