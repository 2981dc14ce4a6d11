#include "asap/algorithms/arc_star.hpp"

#include "algorithms/arc_length.hpp"
#include "algorithms/corner_ring.hpp"

namespace asap {

template class CornerDetector<ArcStarRule>;

ArcStarRule::ArcStarRule(const Config& config)
    : frame_(config.width, config.height), filter_(frame_, config.filter_us), surface_(frame_) {}

bool ArcStarRule::is_corner(const Event& event) noexcept {
  if (!filter_.passes(event)) return false;
  OrderSurface::Number* pixel = surface_.pixel(event);
  *pixel = surface_.next(event.t);
  return frame_.contains(event, kRingMargin) && has_corner_arcs(pixel, surface_.stride());
}

void ArcStarRule::clear() noexcept {
  filter_.clear();
  surface_.clear();
}

}  // namespace asap
