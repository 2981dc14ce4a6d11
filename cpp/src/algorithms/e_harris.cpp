#include "asap/algorithms/e_harris.hpp"

#include "algorithms/harris_score.hpp"

namespace asap {
namespace {

// One column and row more than the rings have: the window reaches into the padding there.
bool has_window(const Event& event, const SensorFrame& frame) noexcept {
  return event.x >= 4 && event.x + 4U <= frame.width() && event.y >= 4 &&
         event.y + 4U <= frame.height();
}

}  // namespace

template class CornerDetector<EHarrisRule>;

EHarrisRule::EHarrisRule(const Config& config)
    : frame_(config.width, config.height),
      threshold_(checked_threshold(config.threshold)),
      surface_(frame_) {}

bool EHarrisRule::is_corner(const Event& event) noexcept {
  OrderSurface::Number* pixel = surface_.pixel(event);
  *pixel = surface_.next();
  PatchRows rows;
  return has_window(event, frame_) && patch_.select(pixel, surface_.stride(), rows) &&
         harris_score(rows) > threshold_;
}

void EHarrisRule::clear() noexcept {
  surface_.clear();
  patch_.clear();
}

}  // namespace asap
