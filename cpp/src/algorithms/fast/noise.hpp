// Noise: which events are noise, and its rate per pixel. SupportMap: an event has support if one of
// its eight neighbours, of either polarity, fired at most a window ago. The own pixel does not
// count, so a pixel that flashes alone never has support. NoiseTiles: the rate of unsupported
// events. Objects fill few of the tiles, so a low quantile of the tiles' rates is noise alone. The
// functions correct that rate for noise that has support by chance. One thread. O(1) per event,
// O(tiles) per update(), which is called every few ms; allocates in the constructors only.
// Source: the support of BackgroundActivityFilter (Delbruck 2008), here on stamps modulo 2^32; the
// rate: own design.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/time.hpp"
#include "algorithms/int4.hpp"

namespace asap::inline v0_1::fast {

class SupportMap {
 public:
  SupportMap(int width, int height)
      : stride_(static_cast<std::size_t>(width) + 2),
        // Each row of three neighbours is read as four pixels.
        stamps_(stride_ * (static_cast<std::size_t>(height) + 2) + 1),
        scrubber_(stamps_.size()) {}

  void clear(Stamp now) noexcept {
    std::fill(stamps_.begin(), stamps_.end(), static_cast<std::int32_t>(long_before(now)));
  }

  // Whether an event at a pixel of the frame has support. Notes the event.
  bool touch(std::size_t x, std::size_t y, Stamp now, std::int32_t window_us) noexcept {
    std::int32_t* corner = stamps_.data() + y * stride_ + x;
    const auto since = static_cast<std::int32_t>(now - static_cast<Stamp>(window_us));
    const auto row = Int4::load(corner + stride_);
    const std::uint32_t outer =
        Int4::mask_before(Int4::load(corner), Int4::load(corner + 2 * stride_), since);
    const std::uint32_t old = outer & (Int4::mask_before(row, row, since) | 0b010);
    corner[stride_ + 1] = static_cast<std::int32_t>(now);
    return (old & 0b111) != 0b111;
  }

  void scrub(Stamp now, std::uint64_t elapsed_us) noexcept {
    scrubber_.scrub(stamps_.data(), now, elapsed_us,
                    [](std::int32_t& stamp) -> std::int32_t& { return stamp; });
  }

 private:
  std::size_t stride_;
  std::vector<std::int32_t> stamps_;  // has a border of one pixel around the frame
  Scrubber scrubber_;
};

class NoiseTiles {
 public:
  NoiseTiles(int width, int height);

  void count(std::size_t x, std::size_t y) noexcept {
    ++events_[(y >> shift_) * columns_ + (x >> shift_)];
  }

  // Updates the rate; the counts are those of the last dt_s.
  void update(float dt_s) noexcept;

  // Counted events per second and pixel where there are no objects.
  float rate_hz() const noexcept { return rate_hz_; }

  // The same around a place: of its tile, which counts twice, and those around it.
  float rate_near_hz(float x, float y) const noexcept;

  void clear() noexcept;

  std::size_t size() const noexcept { return events_.size(); }

 private:
  int shift_;
  std::size_t columns_;
  std::vector<std::int32_t> events_;  // by tile, as the next two: since the last update
  std::vector<float> pixels_;
  std::vector<float> rates_hz_;  // per pixel
  std::vector<float> sorted_;
  float age_s_ = 0;
  float rate_hz_ = 0;
};

// The rate of all noise per pixel, from the rate of its unsupported events: solves
// unsupported = all exp(-8 all window) for `all`.
float total_noise(float unsupported_hz, float window_s) noexcept;

// The rate of the noise that has support, from the rate of all noise.
float supported_noise(float noise_hz, float window_s) noexcept;

// The window of the support, as long as the noise allows but at least `shortest_us`: the pixels of
// a slow edge fire tens of ms apart.
std::int32_t support_window_us(float noise_hz, std::int32_t shortest_us,
                               std::int32_t longest_us) noexcept;

}  // namespace asap::inline v0_1::fast
