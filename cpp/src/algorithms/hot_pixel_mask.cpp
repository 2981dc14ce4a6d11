#include "asap/algorithms/noise_filters.hpp"

#include <algorithm>

#include "algorithms/sensor_frame.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {
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

class HotPixelMask::Impl {
 public:
  explicit Impl(const Config& given)
      : config(checked(given)),
        frame_(config.width, config.height),
        stride_(frame_.width() + 2 * kReach),
        first_(kReach * stride_ + kReach),
        cells_(stride_ * (frame_.height() + 2 * kReach)) {
    mask_given();
  }

  std::size_t process(EventSpan events, std::span<Event> out) noexcept {
    const auto learn_events = static_cast<std::uint64_t>(config.learn_events);
    std::size_t passed = 0;
    for (const Event event : events) {
      if (!frame_.contains(event)) [[unlikely]] {
        ++rejected;
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

  std::size_t learn(EventSpan events) noexcept {
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

  bool is_masked(std::uint32_t x, std::uint32_t y) const noexcept {
    return (cells_[index(x, y)] & kMasked) != 0;
  }

  std::vector<MaskedPixel> pixels() const {
    std::vector<MaskedPixel> pixels;
    for (std::uint32_t y = 0; y < frame_.height(); ++y) {
      for (std::uint32_t x = 0; x < frame_.width(); ++x) {
        if (is_masked(x, y)) pixels.push_back({static_cast<int>(x), static_cast<int>(y)});
      }
    }
    return pixels;
  }

  void reset() noexcept {
    std::fill(cells_.begin(), cells_.end(), 0);
    mask_given();
    counted_ = 0;
    rejected = 0;
  }

  Config config;
  std::uint64_t rejected = 0;

 private:
  using Cell = std::uint32_t;
  static constexpr Cell kMasked = Cell{1} << 31;  // the bits below count events
  static constexpr std::uint32_t kReach = 2;      // px around a pixel that are its neighbours

  std::size_t index(std::uint32_t x, std::uint32_t y) const noexcept {
    return y * stride_ + x + first_;
  }

  void mask_given() noexcept {
    for (const auto& [x, y] : config.pixels) {
      cells_[index(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y))] |= kMasked;
    }
  }

  void forget_counts() noexcept {
    for (Cell& cell : cells_) cell &= kMasked;
    counted_ = 0;
  }

  std::size_t mask_hot() noexcept {
    std::size_t hot = 0;
    for (std::size_t i = first_; i < cells_.size() - first_; ++i) {
      const std::uint64_t count = cells_[i] & ~kMasked;
      if (count < kHotEvents || kHotShare * count < counted_ || !is_hot(&cells_[i])) continue;
      cells_[i] |= kMasked;
      ++hot;
    }
    return hot;
  }

  bool is_hot(const Cell* cell) const noexcept {
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

  SensorFrame frame_;
  std::size_t stride_;
  std::size_t first_;        // index of the first pixel
  std::vector<Cell> cells_;  // a border of kReach pixels lies around the frame
  std::uint64_t counted_ = 0;
};

HotPixelMask::HotPixelMask(const Config& config) : impl_(std::make_unique<Impl>(config)) {}
HotPixelMask::~HotPixelMask() = default;
HotPixelMask::HotPixelMask(const HotPixelMask& other)
    : impl_(std::make_unique<Impl>(*other.impl_)) {}
HotPixelMask& HotPixelMask::operator=(const HotPixelMask& other) {
  return *this = HotPixelMask(other);
}
HotPixelMask::HotPixelMask(HotPixelMask&&) noexcept = default;
HotPixelMask& HotPixelMask::operator=(HotPixelMask&&) noexcept = default;

std::size_t HotPixelMask::process(EventSpan events, std::span<Event> out) noexcept {
  return impl_->process(events, out);
}

std::size_t HotPixelMask::learn(EventSpan events) noexcept { return impl_->learn(events); }

bool HotPixelMask::is_masked(std::uint32_t x, std::uint32_t y) const noexcept {
  return impl_->is_masked(x, y);
}

std::vector<MaskedPixel> HotPixelMask::pixels() const { return impl_->pixels(); }

void HotPixelMask::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

void HotPixelMask::reset() noexcept { impl_->reset(); }

std::uint64_t HotPixelMask::rejected() const noexcept { return impl_->rejected; }

const HotPixelMask::Config& HotPixelMask::config() const noexcept { return impl_->config; }

}  // namespace asap::inline v0_1
