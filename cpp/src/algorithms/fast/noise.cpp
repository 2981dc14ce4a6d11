#include "algorithms/fast/noise.hpp"

#include <algorithm>
#include <cmath>

namespace asap::inline v0_1::fast {
namespace {

constexpr int kSmallestShift = 4;
constexpr std::size_t kMaxTiles = 512;
constexpr float kMemory_s = 0.2F;

std::size_t tiles_along(int side, int shift) {
  return (static_cast<std::size_t>(side - 1) >> shift) + 1;
}

int shift_for(int width, int height) {
  int shift = kSmallestShift;
  while (tiles_along(width, shift) * tiles_along(height, shift) > kMaxTiles) ++shift;
  return shift;
}

}  // namespace

NoiseTiles::NoiseTiles(int width, int height)
    : shift_(shift_for(width, height)),
      columns_(tiles_along(width, shift_)),
      events_(columns_ * tiles_along(height, shift_)),
      pixels_(events_.size()),
      rates_hz_(events_.size()),
      sorted_(events_.size()) {
  const auto length = [&](std::size_t index, int side) {
    return static_cast<float>(std::min(1 << shift_, side - static_cast<int>(index << shift_)));
  };
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    pixels_[i] = length(i % columns_, width) * length(i / columns_, height);
  }
}

void NoiseTiles::update(float dt_s) noexcept {
  age_s_ += dt_s;
  const float weight = low_pass_weight(decay(dt_s / kMemory_s), dt_s, age_s_);
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const float rate = static_cast<float>(events_[i]) / (dt_s * pixels_[i]);
    rates_hz_[i] += weight * (rate - rates_hz_[i]);
  }
  std::ranges::fill(events_, 0);
  std::ranges::copy(rates_hz_, sorted_.begin());
  const auto low = sorted_.begin() + static_cast<std::ptrdiff_t>(3 * sorted_.size() / 10);
  std::nth_element(sorted_.begin(), low, sorted_.end());
  // The 30 % quantile lies 0.52 standard deviations below the mean of the counts; the low pass
  // averages over twice its time constant.
  const float events = *low * 2 * kMemory_s * static_cast<float>(1 << (2 * shift_));
  rate_hz_ = *low * (1 + 0.52F / std::sqrt(std::max(1.0F, events)));
}

float NoiseTiles::rate_near_hz(float x, float y) const noexcept {
  const std::size_t rows = pixels_.size() / columns_;
  const auto tile_at = [&](float position, std::size_t count) {
    const auto last = static_cast<float>((count << shift_) - 1);
    return static_cast<std::size_t>(std::clamp(position, 0.0F, last)) >> shift_;
  };
  const std::size_t column = tile_at(x, columns_);
  const std::size_t row = tile_at(y, rows);
  float events_hz = 0;
  float pixels = 0;
  const auto add = [&](std::size_t tile) {
    events_hz += rates_hz_[tile] * pixels_[tile];
    pixels += pixels_[tile];
  };
  for (std::size_t r = row - (row > 0); r <= std::min(rows - 1, row + 1); ++r) {
    for (std::size_t c = column - (column > 0); c <= std::min(columns_ - 1, column + 1); ++c) {
      add(r * columns_ + c);
    }
  }
  add(row * columns_ + column);
  return events_hz / pixels;
}

void NoiseTiles::clear() noexcept {
  std::ranges::fill(events_, 0);
  std::ranges::fill(rates_hz_, 0.0F);
  age_s_ = 0;
  rate_hz_ = 0;
}

float total_noise(float unsupported_hz, float window_s) noexcept {
  float all_hz = unsupported_hz;
  for (int iteration = 0; iteration < 12; ++iteration) {
    all_hz = unsupported_hz / decay(std::min(1.0F, 8 * all_hz * window_s));
  }
  return all_hz;
}

float supported_noise(float noise_hz, float window_s) noexcept {
  return noise_hz * (1 - decay(8 * noise_hz * window_s));
}

std::int32_t support_window_us(float noise_hz, std::int32_t shortest_us,
                               std::int32_t longest_us) noexcept {
  constexpr float kMaxNoiseSupport = 0.1F;  // noise events around a pixel within the window
  const float allowed_us = 1e6F * kMaxNoiseSupport / std::max(1e-3F, 8 * noise_hz);
  const auto longest = static_cast<float>(std::max(shortest_us, longest_us));
  return static_cast<std::int32_t>(
      std::clamp(allowed_us, static_cast<float>(shortest_us), longest));
}

}  // namespace asap::inline v0_1::fast
