#include "asap/algorithms/event_surface.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "algorithms/padded_plane.hpp"
#include "algorithms/sensor_frame.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

using Ordinal = ThresholdOrdinalSurface::Value;
constexpr std::size_t kOrdinalLanes = PaddedPlane<Ordinal>::kLanes;
constexpr Ordinal kNewest = 255;

using Rank = SpeedInvariantTimeSurface::Value;
constexpr std::size_t kRankLanes = PaddedPlane<Rank>::kLanes;
constexpr Rank kAboveAll = 65535;

int checked_side(int side) {
  require(3 <= side && side <= 127 && side % 2 == 1, "side", side, "must be odd, 3 to 127 px");
  return side;
}

int checked_radius(int radius) {
  // The top rank of 127, 65025, lies below kAboveAll.
  require(1 <= radius && radius <= 127, "radius", radius, "must be 1 to 127 px");
  return radius;
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

// Nothing ranks above kAboveAll, so what lies beyond the window stays. Vector instructions as in
// fade().
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

// A rule checks its configuration in the constructor. update() sees every event in the frame.

class ThresholdOrdinalRule {
 public:
  explicit ThresholdOrdinalRule(const ThresholdOrdinalSurfaceConfig& config)
      : side_(checked_side(config.side)),
        frame_(config.width, config.height),
        plane_(frame_, static_cast<std::uint32_t>(side_ / 2)),
        steps_(plane_.blocks() * kOrdinalLanes, 0),
        bars_(plane_.blocks() * kOrdinalLanes, 0) {
    std::fill_n(steps_.begin(), side_, Ordinal{1});
    std::fill_n(bars_.begin(), side_, static_cast<Ordinal>(kNewest - 2 * side_));
  }

  void update(const Event& event) noexcept {
    Ordinal* row = plane_.corner(event);
    for (int y = 0; y < side_; ++y, row += plane_.stride()) {
      for (std::size_t i = 0; i < steps_.size(); i += kOrdinalLanes)
        fade(row + i, &steps_[i], &bars_[i]);
    }
    *plane_.pixel(event.x, event.y) = kNewest;
  }

  PaddedPlane<Ordinal>& plane() noexcept { return plane_; }
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  int side_;
  SensorFrame frame_;
  PaddedPlane<Ordinal> plane_;
  // Per column of the blocks: what an event takes away, and the largest value that it clears. 0 and
  // 0, which change nothing, beyond the window.
  std::vector<Ordinal> steps_;
  std::vector<Ordinal> bars_;
};

class SpeedInvariantTimeRule {
 public:
  explicit SpeedInvariantTimeRule(const SpeedInvariantTimeSurfaceConfig& config)
      : side_(2 * checked_radius(config.radius) + 1),
        frame_(config.width, config.height),
        plane_(frame_, static_cast<std::uint32_t>(config.radius)),
        beyond_(plane_.blocks() * kRankLanes, kAboveAll) {
    std::fill_n(beyond_.begin(), side_, Rank{0});
  }

  void update(const Event& event) noexcept {
    Rank* const own = plane_.pixel(event.x, event.y);
    const Rank rank = *own;
    Rank* row = plane_.corner(event);
    for (int y = 0; y < side_; ++y, row += plane_.stride()) {
      for (std::size_t i = 0; i < beyond_.size(); i += kRankLanes)
        lower(row + i, &beyond_[i], rank);
    }
    *own = static_cast<Rank>(side_ * side_);
  }

  PaddedPlane<Rank>& plane() noexcept { return plane_; }
  const SensorFrame& frame() const noexcept { return frame_; }

 private:
  int side_;
  SensorFrame frame_;
  PaddedPlane<Rank> plane_;
  std::vector<Rank> beyond_;  // per column of the blocks: all bits set beyond the window, else 0
};

template <class Rule, class Configuration, class Pixel>
EventSurface<Rule, Configuration, Pixel>::EventSurface(const Config& config)
    : config_(config), rule_(std::make_unique<Rule>(config)) {}
template <class Rule, class Configuration, class Pixel>
EventSurface<Rule, Configuration, Pixel>::~EventSurface() = default;
template <class Rule, class Configuration, class Pixel>
EventSurface<Rule, Configuration, Pixel>::EventSurface(const EventSurface& other)
    : config_(other.config_),
      rule_(std::make_unique<Rule>(*other.rule_)),
      rejected_(other.rejected_) {}
template <class Rule, class Configuration, class Pixel>
EventSurface<Rule, Configuration, Pixel>& EventSurface<Rule, Configuration, Pixel>::operator=(
    const EventSurface& other) {
  return *this = EventSurface(other);
}
template <class Rule, class Configuration, class Pixel>
EventSurface<Rule, Configuration, Pixel>::EventSurface(EventSurface&&) noexcept = default;
template <class Rule, class Configuration, class Pixel>
EventSurface<Rule, Configuration, Pixel>& EventSurface<Rule, Configuration, Pixel>::operator=(
    EventSurface&&) noexcept = default;

template <class Rule, class Configuration, class Pixel>
void EventSurface<Rule, Configuration, Pixel>::process(EventSpan events) noexcept {
  Rule& rule = *rule_;
  for (const Event& event : events) {
    if (!rule.frame().contains(event)) [[unlikely]] {
      ++rejected_;
      continue;
    }
    rule.update(event);
  }
}

template <class Rule, class Configuration, class Pixel>
Pixel EventSurface<Rule, Configuration, Pixel>::at(std::uint32_t x,
                                                   std::uint32_t y) const noexcept {
  return rule_->plane().at(x, y);
}

template <class Rule, class Configuration, class Pixel>
void EventSurface<Rule, Configuration, Pixel>::copy_to(std::span<Value> out) const {
  rule_->plane().copy_to(out);
}

template <class Rule, class Configuration, class Pixel>
void EventSurface<Rule, Configuration, Pixel>::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

template <class Rule, class Configuration, class Pixel>
void EventSurface<Rule, Configuration, Pixel>::reset() noexcept {
  rule_->plane().clear();
  rejected_ = 0;
}

template class EventSurface<ThresholdOrdinalRule, ThresholdOrdinalSurfaceConfig, Ordinal>;
template class EventSurface<SpeedInvariantTimeRule, SpeedInvariantTimeSurfaceConfig, Rank>;

}  // namespace asap::inline v0_1
