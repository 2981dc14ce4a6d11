#include "asap/algorithms/fa_harris.hpp"

#include "algorithms/arc_length.hpp"
#include "algorithms/corner_ring.hpp"
#include "algorithms/harris_score.hpp"

namespace asap {

template class CornerDetector<FAHarrisRule>;

FAHarrisRule::FAHarrisRule(const Config& config)
    : frame_(config.width, config.height),
      threshold_(checked_threshold(config.threshold)),
      filter_(frame_, config.filter_us),
      stamps_(frame_),
      arrivals_(frame_) {}

bool FAHarrisRule::is_corner(const Event& event) noexcept {
  if (!frame_.contains(event, kRingMargin) || !filter_.passes(event)) return false;
  OrderSurface::Number* stamp = stamps_.pixel(event);
  *stamp = stamps_.next(event.t);
  OrderSurface::Number* arrival = arrivals_.pixel(event);
  *arrival = arrivals_.next();
  PatchRows rows;
  return has_corner_arcs(stamp, stamps_.stride()) &&
         patch_.select(arrival, arrivals_.stride(), rows) && harris_score(rows) > threshold_;
}

void FAHarrisRule::clear() noexcept {
  filter_.clear();
  stamps_.clear();
  arrivals_.clear();
  patch_.clear();
}

}  // namespace asap
