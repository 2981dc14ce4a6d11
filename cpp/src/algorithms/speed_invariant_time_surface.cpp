#include "asap/algorithms/speed_invariant_time_surface.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "asap/core/check.hpp"

namespace asap {
namespace {

using Value = SpeedInvariantTimeRule::Value;
constexpr std::size_t kLanes = PaddedPlane<Value>::kLanes;
constexpr Value kAboveAll = 65535;

int checked_radius(int radius) {
  // The top rank of 127, 65025, lies below kAboveAll.
  require(1 <= radius && radius <= 127, "radius", radius, "must be 1 to 127 px");
  return radius;
}

// Nothing ranks above kAboveAll, so what lies beyond the window stays. Vector instructions: see
// ThresholdOrdinalRule.
void lower(Value* values, const Value* beyond, Value own) noexcept {
  std::array<Value, kLanes> value;
  std::array<Value, kLanes> bar;
  std::copy_n(values, kLanes, value.begin());
  std::copy_n(beyond, kLanes, bar.begin());
  for (std::size_t i = 0; i < kLanes; ++i) {
    bar[i] = static_cast<Value>(bar[i] | own);
    value[i] = static_cast<Value>(value[i] - (value[i] > bar[i] ? 1 : 0));
  }
  std::copy_n(value.begin(), kLanes, values);
}

}  // namespace

template class EventSurface<SpeedInvariantTimeRule>;

SpeedInvariantTimeRule::SpeedInvariantTimeRule(const Config& config)
    : side_(2 * checked_radius(config.radius) + 1),
      frame_(config.width, config.height),
      plane_(frame_, static_cast<std::uint32_t>(config.radius)),
      beyond_(plane_.blocks() * kLanes, kAboveAll) {
  std::fill_n(beyond_.begin(), side_, Value{0});
}

void SpeedInvariantTimeRule::update(const Event& event) noexcept {
  Value* const own = plane_.pixel(event.x, event.y);
  const Value rank = *own;
  Value* row = plane_.corner(event);
  for (int y = 0; y < side_; ++y, row += plane_.stride()) {
    for (std::size_t i = 0; i < beyond_.size(); i += kLanes) lower(row + i, &beyond_[i], rank);
  }
  *own = static_cast<Value>(side_ * side_);
}

}  // namespace asap
