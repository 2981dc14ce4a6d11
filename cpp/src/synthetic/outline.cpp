#include "synthetic/outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace asap::inline v0_1 {
namespace {

std::int32_t rounded(double value) noexcept {
  return static_cast<std::int32_t>(std::floor(value + 0.5));
}

}  // namespace

Outline::Place Outline::place(double x_px, double y_px) noexcept {
  return {rounded(x_px * kUnit), rounded(y_px * kUnit)};
}

std::int32_t Outline::step_us(double fastest_px_s, std::int64_t remaining_us) noexcept {
  const double still_short_us = 1e6 * kLongestSweep_px / fastest_px_s;
  const double longest_us = std::min<double>(still_short_us, TimeSortedBlock::kMaxStep_us);
  return static_cast<std::int32_t>(
      std::min(std::max(longest_us, 1.0), static_cast<double>(remaining_us)));
}

void Outline::add(std::span<const PlanePoint> polygon, PlanePoint offset) {
  constexpr double step = static_cast<double>(kThresholds) * kThreshold / kUnit;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PlanePoint from = polygon[i];
    const PlanePoint to = polygon[(i + 1) % polygon.size()];
    const double dx = to.x - from.x;
    const double dy = to.y - from.y;
    const double length = std::sqrt(dx * dx + dy * dy);
    const std::int32_t count = std::max(1, rounded(length));
    for (std::int32_t j = 0; j < count; ++j) {
      const double along = (j + 0.5) / count;
      const auto level = static_cast<std::int32_t>(random_(drawn_++) % kThreshold);
      points_.push_back({.x = rounded((offset.x + from.x + along * dx) * kUnit),
                         .y = rounded((offset.y + from.y + along * dy) * kUnit),
                         .step_x = rounded(dy / length * step),
                         .step_y = rounded(-dx / length * step),
                         .level = level});
    }
  }
  if (crossed_.size() < points_.size()) crossed_.resize(points_.size());
}

void Outline::reserve(std::size_t points) {
  points_.reserve(points);
  crossed_.resize(points);
}

double Outline::events_per_px(UnitVector direction) const noexcept {
  double sum = 0.0;
  for (const EdgePoint& point : points_) {
    sum += std::abs(point.step_x * direction.x + point.step_y * direction.y);
  }
  return sum * kUnit / kThreshold;
}

void Outline::sweep(Place from, Place to, TimeSortedBlock& block) noexcept {
  const std::int32_t move_x = to.x - from.x;
  const std::int32_t move_y = to.y - from.y;

  // Two loops: whether a point crosses is a coin toss that no branch predictor learns.
  std::size_t crossings = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    EdgePoint& point = points_[i];
    point.level += point.step_x * move_x + point.step_y * move_y;
    crossed_[crossings] = static_cast<std::uint32_t>(i);
    crossings += static_cast<std::uint32_t>(point.level) >= kThreshold;
  }

  const std::int32_t middle_x = from.x + move_x / 2;
  const std::int32_t middle_y = from.y + move_y / 2;
  const std::int32_t last_us = block.step_us() - 1;
  for (std::size_t i = 0; i < crossings; ++i) {
    EdgePoint& point = points_[crossed_[i]];
    const bool withdraws = point.level < 0;
    const std::int32_t beyond = withdraws ? -point.level : point.level - kThreshold;
    const std::int32_t change = std::abs(point.step_x * move_x + point.step_y * move_y);
    const double share = static_cast<double>(change - beyond) / change;
    const auto offset_us = static_cast<std::int32_t>(share * block.step_us());
    point.level &= kThreshold - 1;
    block.add((point.x + middle_x) >> kUnitBits, (point.y + middle_y) >> kUnitBits, withdraws,
              std::min(offset_us, last_us));
  }
}

}  // namespace asap::inline v0_1
