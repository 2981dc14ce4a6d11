#include "asap/algorithms/threshold_ordinal_surface.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "asap/core/check.hpp"

namespace asap {
namespace {

using Ordinal = ThresholdOrdinalRule::Value;
constexpr std::size_t kOrdinalLanes = PaddedPlane<Ordinal>::kLanes;
constexpr Ordinal kNewest = 255;

int checked_side(int side) {
  require(3 <= side && side <= 127 && side % 2 == 1, "side", side, "must be odd, 3 to 127 px");
  return side;
}

// One vector instruction each where the machine has them: the copies leave the compiler no doubt
// that the arrays are apart.
void fade(Ordinal* values, const Ordinal* steps, const Ordinal* bars) noexcept {
  std::array<Ordinal, kOrdinalLanes> value;
  std::array<Ordinal, kOrdinalLanes> step;
  std::array<Ordinal, kOrdinalLanes> bar;
  std::copy_n(values, kOrdinalLanes, value.begin());
  std::copy_n(steps, kOrdinalLanes, step.begin());
  std::copy_n(bars, kOrdinalLanes, bar.begin());
  for (std::size_t i = 0; i < kOrdinalLanes; ++i) {
    value[i] = value[i] > bar[i] ? static_cast<Ordinal>(value[i] - step[i]) : Ordinal{0};
  }
  std::copy_n(value.begin(), kOrdinalLanes, values);
}

}  // namespace

template class EventSurface<ThresholdOrdinalRule>;

ThresholdOrdinalRule::ThresholdOrdinalRule(const Config& config)
    : side_(checked_side(config.side)),
      frame_(config.width, config.height),
      plane_(frame_, static_cast<std::uint32_t>(side_ / 2)),
      steps_(plane_.blocks() * kOrdinalLanes, 0),
      bars_(plane_.blocks() * kOrdinalLanes, 0) {
  std::fill_n(steps_.begin(), side_, Ordinal{1});
  std::fill_n(bars_.begin(), side_, static_cast<Ordinal>(kNewest - 2 * side_));
}

void ThresholdOrdinalRule::update(const Event& event) noexcept {
  Ordinal* row = plane_.corner(event);
  for (int y = 0; y < side_; ++y, row += plane_.stride()) {
    for (std::size_t i = 0; i < steps_.size(); i += kOrdinalLanes)
      fade(row + i, &steps_[i], &bars_[i]);
  }
  *plane_.pixel(event.x, event.y) = kNewest;
}

}  // namespace asap
