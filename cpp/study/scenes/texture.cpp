#include "study/scenes/texture.hpp"

#include <cmath>
#include <cstddef>

#include "core/check.hpp"

namespace asap {
namespace {

constexpr std::int64_t kPeriod = 64;  // lattice points

}  // namespace

Texture::Texture(CounterRandom random, double pitch_px, double low, double high)
    : inverse_pitch_(1.0 / pitch_px) {
  require(pitch_px >= 1.0 && pitch_px <= 1000.0, "pitch_px", pitch_px, "give 1 to 1000 px");
  require(low >= 0.0 && low <= high && high <= 2.0, "low", low,
          "give 0 to high, and that at most 2");
  for (std::uint64_t i = 0; i < kPeriod * kPeriod; ++i) {
    values_.push_back(low + (high - low) * random.uniform(i));
  }
}

double Texture::at(PlanePoint point) const noexcept {
  const double x = point.x * inverse_pitch_;
  const double y = point.y * inverse_pitch_;
  const double left = std::floor(x);
  const double top = std::floor(y);
  const auto value = [&](std::int64_t column, std::int64_t row) {
    return values_[static_cast<std::size_t>((column & (kPeriod - 1)) +
                                            kPeriod * (row & (kPeriod - 1)))];
  };
  const auto column = static_cast<std::int64_t>(left);
  const auto row = static_cast<std::int64_t>(top);
  const double right_share = x - left;
  const double low_share = y - top;
  const double above =
      value(column, row) * (1.0 - right_share) + value(column + 1, row) * right_share;
  const double below =
      value(column, row + 1) * (1.0 - right_share) + value(column + 1, row + 1) * right_share;
  return above * (1.0 - low_share) + below * low_share;
}

MovingGround::MovingGround(const MovingGroundConfig& config, std::int32_t width,
                           std::int32_t height, CounterRandom random)
    : config_(config),
      texture_(random, config.pitch_px, config.low, config.high),
      middle_{0.5 * (width - 1), 0.5 * (height - 1)} {
  const auto at_most = [](double value, double most, const char* field, const char* remedy) {
    require(value >= -most && value <= most, field, value, remedy);
  };
  at_most(config.shift_px_s.x, 2000.0, "shift_px_s.x", "give -2000 to 2000 px/s");
  at_most(config.shift_px_s.y, 2000.0, "shift_px_s.y", "give -2000 to 2000 px/s");
  at_most(config.turn_rad_s, 100.0, "turn_rad_s", "give -100 to 100 rad/s");
  require(config.zoom_per_s >= 0.0 && config.zoom_per_s <= 10.0, "zoom_per_s", config.zoom_per_s,
          "give 0 to 10 per s");
}

double MovingGround::brightness(std::int32_t x, std::int32_t y) const noexcept {
  const double dx = (x - middle_.x) / scale_;
  const double dy = (y - middle_.y) / scale_;
  return texture_.at(
      {dx * axis_.x + dy * axis_.y - shift_.x, dy * axis_.x - dx * axis_.y - shift_.y});
}

PlanePoint MovingGround::moved(PlanePoint start) const noexcept {
  const double x = scale_ * (start.x - middle_.x + shift_.x);
  const double y = scale_ * (start.y - middle_.y + shift_.y);
  return {middle_.x + x * axis_.x - y * axis_.y, middle_.y + y * axis_.x + x * axis_.y};
}

void MovingGround::advance(std::int32_t step_us) noexcept {
  const double step_s = 1e-6 * step_us;
  shift_.x += config_.shift_px_s.x * step_s;
  shift_.y += config_.shift_px_s.y * step_s;
  axis_ = axis_.turned(0.5 * config_.turn_rad_s * step_s);
  scale_ += config_.zoom_per_s * step_s;
}

}  // namespace asap
