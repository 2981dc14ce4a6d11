#include "synthetic/background_noise.hpp"

#include "asap/core/check.hpp"

namespace asap {

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
    const std::uint64_t bits = mix(random_(microsecond));
    const auto x = static_cast<std::int32_t>(((bits & 0xffffffffU) * width_) >> 32);
    const auto y = static_cast<std::int32_t>(((bits >> 33) * height_) >> 31);
    block.add(x, y, (bits >> 32 & 1) != 0, offset_us);
  }
}

}  // namespace asap
