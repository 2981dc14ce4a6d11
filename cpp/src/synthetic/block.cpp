#include "synthetic/block.hpp"

#include <algorithm>
#include <utility>

#include "core/check.hpp"

namespace asap::inline v0_1 {

TimeSortedBlock::TimeSortedBlock(std::int32_t width, std::int32_t height, std::size_t capacity)
    : width_(static_cast<std::uint32_t>(width)),
      height_(static_cast<std::uint32_t>(height)),
      added_(capacity),
      places_(kMaxStep_us),
      sorted_(capacity) {}

void TimeSortedBlock::open(std::int64_t start_us, std::int32_t step_us) noexcept {
  start_us_ = start_us;
  step_us_ = step_us;
  size_ = 0;
}

EventSpan TimeSortedBlock::close() noexcept {
  const auto places_end = places_.begin() + step_us_;
  std::fill(places_.begin(), places_end, 0U);
  for (std::size_t i = 0; i < size_; ++i) ++places_[added_[i].offset_us];

  std::uint32_t before = 0;
  for (auto place = places_.begin(); place != places_end; ++place) {
    before += std::exchange(*place, before);
  }

  for (std::size_t i = 0; i < size_; ++i) {
    const Added& added = added_[i];
    Event& event = sorted_[places_[added.offset_us]++];
    // Field by field: the padding of the buffer stays zero.
    event.x = added.x;
    event.y = added.y;
    event.p = static_cast<std::int16_t>(added.on);
    event.t = start_us_ + added.offset_us;
  }
  return {sorted_.data(), size_};
}

BackgroundNoise::BackgroundNoise(std::int32_t width, std::int32_t height, double noise_hz,
                                 std::uint64_t seed)
    : random_(seed),
      width_(static_cast<std::uint64_t>(width)),
      height_(static_cast<std::uint64_t>(height)),
      probability_(noise_hz * width * height * 1e-6) {
  require(noise_hz >= 0.0 && probability_ <= 1.0, "noise_hz", noise_hz,
          "give events per second and pixel, 0 or more, at most 1e6 / (width x height)");
}

void BackgroundNoise::add_to(TimeSortedBlock& block, std::int64_t elapsed_us) const noexcept {
  for (std::int32_t offset_us = 0; offset_us < block.step_us(); ++offset_us) {
    const auto microsecond = static_cast<std::uint64_t>(elapsed_us + offset_us);
    if (random_.uniform(microsecond) >= probability_) continue;
    const std::uint64_t bits = detail::mix(random_(microsecond));
    const auto x = static_cast<std::int32_t>(((bits & 0xffffffffU) * width_) >> 32);
    const auto y = static_cast<std::int32_t>(((bits >> 33) * height_) >> 31);
    block.add(x, y, (bits >> 32 & 1) != 0, offset_us);
  }
}

}  // namespace asap::inline v0_1
