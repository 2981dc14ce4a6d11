#include "asap/algorithms/threshold_ordinal_surface.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "asap/core/check.hpp"

namespace asap {
namespace {

using Value = ThresholdOrdinalRule::Value;
constexpr std::size_t kLanes = PaddedPlane<Value>::kLanes;
constexpr Value kNewest = 255;

int checked_side(int side) {
  require(3 <= side && side <= 127 && side % 2 == 1, "side", side, "must be odd, 3 to 127 px");
  return side;
}

// One vector instruction each where the machine has them: the copies leave the compiler no doubt
// that the arrays are apart.
void fade(Value* values, const Value* steps, const Value* bars) noexcept {
  std::array<Value, kLanes> value;
  std::array<Value, kLanes> step;
  std::array<Value, kLanes> bar;
  std::copy_n(values, kLanes, value.begin());
  std::copy_n(steps, kLanes, step.begin());
  std::copy_n(bars, kLanes, bar.begin());
  for (std::size_t i = 0; i < kLanes; ++i) {
    value[i] = value[i] > bar[i] ? static_cast<Value>(value[i] - step[i]) : Value{0};
  }
  std::copy_n(value.begin(), kLanes, values);
}

}  // namespace

template class EventSurface<ThresholdOrdinalRule>;

ThresholdOrdinalRule::ThresholdOrdinalRule(const Config& config)
    : side_(checked_side(config.side)),
      frame_(config.width, config.height),
      plane_(frame_, static_cast<std::uint32_t>(side_ / 2)),
      steps_(plane_.blocks() * kLanes, 0),
      bars_(plane_.blocks() * kLanes, 0) {
  std::fill_n(steps_.begin(), side_, Value{1});
  std::fill_n(bars_.begin(), side_, static_cast<Value>(kNewest - 2 * side_));
}

void ThresholdOrdinalRule::update(const Event& event) noexcept {
  Value* row = plane_.corner(event);
  for (int y = 0; y < side_; ++y, row += plane_.stride()) {
    for (std::size_t i = 0; i < steps_.size(); i += kLanes) fade(row + i, &steps_[i], &bars_[i]);
  }
  *plane_.pixel(event.x, event.y) = kNewest;
}

}  // namespace asap
