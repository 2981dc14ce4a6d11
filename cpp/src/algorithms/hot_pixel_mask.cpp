#include "asap/algorithms/hot_pixel_mask.hpp"

#include <algorithm>

#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr std::int64_t kMaxLearnEvents = 1'000'000'000;  // cells count up to 2^31 - 1

const HotPixelMaskConfig& checked(const HotPixelMaskConfig& config) {
  require(0 <= config.learn_events && config.learn_events <= kMaxLearnEvents, "learn_events",
          config.learn_events, "must be 0 to 10^9 events");
  for (const MaskedPixel& pixel : config.pixels) {
    require(0 <= pixel.x && pixel.x < config.width, "pixels: x", pixel.x, "must lie in the frame");
    require(0 <= pixel.y && pixel.y < config.height, "pixels: y", pixel.y, "must lie in the frame");
  }
  return config;
}

}  // namespace

HotPixelMask::HotPixelMask(const Config& config)
    : config_(checked(config)),
      frame_(config.width, config.height),
      stride_(frame_.width() + 2 * kReach),
      first_(kReach * stride_ + kReach),
      cells_(stride_ * (frame_.height() + 2 * kReach)) {
  mask_given();
}

std::size_t HotPixelMask::process(EventSpan events, Event* out) noexcept {
  const auto learn_events = static_cast<std::uint64_t>(config_.learn_events);
  std::size_t passed = 0;
  for (const Event event : events) {
    if (!frame_.contains(event)) [[unlikely]] {
      ++rejected_;
      continue;
    }
    Cell& cell = cells_[index(event.x, event.y)];
    out[passed] = event;
    passed += (cell & kMasked) == 0;
    if (learn_events == 0) continue;
    ++cell;
    if (++counted_ == learn_events) [[unlikely]] {
      mask_hot();
      forget_counts();
    }
  }
  return passed;
}

std::size_t HotPixelMask::learn(EventSpan events) noexcept {
  forget_counts();
  for (const Event& event : events) {
    if (!frame_.contains(event)) continue;
    Cell& cell = cells_[index(event.x, event.y)];
    if ((cell & ~kMasked) == kMasked - 1) continue;
    ++cell;
    ++counted_;
  }
  const std::size_t hot = mask_hot();
  forget_counts();
  return hot;
}

std::size_t HotPixelMask::mask_hot() noexcept {
  std::size_t hot = 0;
  for (std::size_t i = first_; i < cells_.size() - first_; ++i) {
    const std::uint64_t count = cells_[i] & ~kMasked;
    if (count < kHotEvents || kHotShare * count < counted_ || !is_hot(&cells_[i])) continue;
    cells_[i] |= kMasked;
    ++hot;
  }
  return hot;
}

bool HotPixelMask::is_hot(const Cell* cell) const noexcept {
  Cell busiest = 0;
  Cell second = 0;
  const Cell* row = cell - kReach * stride_ - kReach;
  for (std::uint32_t y = 0; y <= 2 * kReach; ++y, row += stride_) {
    for (const Cell* other = row; other <= row + 2 * kReach; ++other) {
      if (other == cell) continue;
      const Cell count = *other & ~kMasked;
      second = std::max(second, std::min(busiest, count));
      busiest = std::max(busiest, count);
    }
  }
  return (*cell & ~kMasked) >= kHotFactor * std::max<std::uint64_t>(second, 1);
}

std::vector<MaskedPixel> HotPixelMask::pixels() const {
  std::vector<MaskedPixel> pixels;
  for (std::uint32_t y = 0; y < frame_.height(); ++y) {
    for (std::uint32_t x = 0; x < frame_.width(); ++x) {
      if (is_masked(x, y)) pixels.push_back({static_cast<int>(x), static_cast<int>(y)});
    }
  }
  return pixels;
}

void HotPixelMask::set_keep(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

void HotPixelMask::mask_given() noexcept {
  for (const auto& [x, y] : config_.pixels) {
    cells_[index(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y))] |= kMasked;
  }
}

void HotPixelMask::forget_counts() noexcept {
  for (Cell& cell : cells_) cell &= kMasked;
  counted_ = 0;
}

void HotPixelMask::reset() noexcept {
  std::fill(cells_.begin(), cells_.end(), 0);
  mask_given();
  counted_ = 0;
  rejected_ = 0;
}

}  // namespace asap
