#include "asap/algorithms/e_fast.hpp"

#include <bit>

#include "algorithms/corner_ring.hpp"

namespace asap {
namespace {

// Whether the newest pixels, `shortest` to `longest` of them, are an arc. If they are, the arc that
// grows from the newest is never left before it has them all.
template <class Ring>
bool has_newest_arc(const Ring& ring, int shortest, int longest) noexcept {
  GrowingArc arc(ring);
  int length = shortest;
  while (length <= longest) {
    arc.grow_to(length);
    const int as_new = std::popcount(ring.at_least(arc.oldest()));
    if (as_new == length) return true;
    length = as_new;  // a shorter arc would leave out some of these
  }
  return false;
}

}  // namespace

template class CornerDetector<EFastRule>;

EFastRule::EFastRule(const Config& config)
    : frame_(config.width, config.height), surface_(frame_) {}

bool EFastRule::is_corner(const Event& event) noexcept {
  OrderSurface::Number* pixel = surface_.pixel(event);
  *pixel = surface_.next(event.t);
  if (!frame_.contains(event, kRingMargin)) return false;
  return has_newest_arc(CornerRing<kRing3>(pixel, surface_.stride()), 3, 6) &&
         has_newest_arc(CornerRing<kRing4>(pixel, surface_.stride()), 4, 8);
}

}  // namespace asap
