#include "asap/algorithms/speed_invariant_time_surface.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "asap/core/check.hpp"

namespace asap {
namespace {

using Rank = SpeedInvariantTimeRule::Value;
constexpr std::size_t kRankLanes = PaddedPlane<Rank>::kLanes;
constexpr Rank kAboveAll = 65535;

int checked_radius(int radius) {
  // The top rank of 127, 65025, lies below kAboveAll.
  require(1 <= radius && radius <= 127, "radius", radius, "must be 1 to 127 px");
  return radius;
}

// Nothing ranks above kAboveAll, so what lies beyond the window stays. Vector instructions: see
// ThresholdOrdinalRule.
void lower(Rank* values, const Rank* beyond, Rank own) noexcept {
  std::array<Rank, kRankLanes> value;
  std::array<Rank, kRankLanes> bar;
  std::copy_n(values, kRankLanes, value.begin());
  std::copy_n(beyond, kRankLanes, bar.begin());
  for (std::size_t i = 0; i < kRankLanes; ++i) {
    bar[i] = static_cast<Rank>(bar[i] | own);
    value[i] = static_cast<Rank>(value[i] - (value[i] > bar[i] ? 1 : 0));
  }
  std::copy_n(value.begin(), kRankLanes, values);
}

}  // namespace

template class EventSurface<SpeedInvariantTimeRule>;

SpeedInvariantTimeRule::SpeedInvariantTimeRule(const Config& config)
    : side_(2 * checked_radius(config.radius) + 1),
      frame_(config.width, config.height),
      plane_(frame_, static_cast<std::uint32_t>(config.radius)),
      beyond_(plane_.blocks() * kRankLanes, kAboveAll) {
  std::fill_n(beyond_.begin(), side_, Rank{0});
}

void SpeedInvariantTimeRule::update(const Event& event) noexcept {
  Rank* const own = plane_.pixel(event.x, event.y);
  const Rank rank = *own;
  Rank* row = plane_.corner(event);
  for (int y = 0; y < side_; ++y, row += plane_.stride()) {
    for (std::size_t i = 0; i < beyond_.size(); i += kRankLanes) lower(row + i, &beyond_[i], rank);
  }
  *own = static_cast<Rank>(side_ * side_);
}

}  // namespace asap
