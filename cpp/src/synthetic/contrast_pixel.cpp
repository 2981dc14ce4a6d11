#include "synthetic/contrast_pixel.hpp"

#include <algorithm>

namespace asap {
namespace {

// When a level that goes linearly from `from` to `to` crosses `crossed`.
std::int32_t crossing_us(double crossed, double from, double to, std::int32_t step_us) noexcept {
  const double way = to - from;
  const double gone = crossed - from;
  if (way == 0.0) return 0;
  const double offset_us = std::clamp(gone / way, 0.0, 1.0) * step_us;
  return std::min(static_cast<std::int32_t>(offset_us), step_us - 1);
}

}  // namespace

std::optional<ContrastPixel::Change> ContrastPixel::move_to(double level, std::int64_t start_us,
                                                            std::int32_t step_us) noexcept {
  std::optional<Change> seen;
  const auto crossed = [&](bool on) {
    const std::int32_t offset_us = crossing_us(reference_, level_, level, step_us);
    if (start_us + offset_us < blind_until_us_) return;
    blind_until_us_ = start_us + offset_us + kRefractory_us;
    seen = {offset_us, on};
  };
  while (level - reference_ >= on_) {
    reference_ += on_;
    crossed(true);
  }
  while (reference_ - level >= off_) {
    reference_ -= off_;
    crossed(false);
  }
  level_ = level;
  return seen;
}

}  // namespace asap
