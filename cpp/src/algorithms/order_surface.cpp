#include "algorithms/order_surface.hpp"

#include <algorithm>

namespace asap {

OrderSurface::OrderSurface(const SensorFrame& frame, Number limit)
    : stride_(frame.width() + 2 * kPad),
      plane_(stride_ * (frame.height() + 2 * kPad)),
      limit_(limit),
      numbers_(2 * plane_, kNever),
      scratch_(std::make_unique_for_overwrite<Number[]>(2 * plane_)) {}

void OrderSurface::clear() noexcept {
  std::fill(numbers_.begin(), numbers_.end(), kNever);
  newest_ = kFirst;
  last_us_ = std::numeric_limits<std::int64_t>::min();
}

void OrderSurface::renumber() noexcept {
  Number* const first = scratch_.get();
  Number* const last = std::remove_copy(numbers_.begin(), numbers_.end(), first, kNever);
  std::sort(first, last);
  for (Number& number : numbers_) {
    if (number == kNever) continue;
    number = kFirst + static_cast<Number>(std::lower_bound(first, last, number) - first);
  }
  newest_ = kFirst + static_cast<Number>(last - first);
}

}  // namespace asap
