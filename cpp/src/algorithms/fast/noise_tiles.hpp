// NoiseTiles: the rate of background events per pixel, from events without support. Objects fill
// few of the tiles, so a low quantile of the tiles' rates is noise alone; from the share of noise
// that has support by chance follows the rate of all noise. One thread. O(1) per event, O(tiles)
// per update(), which is called every few ms; allocates in the constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap::fast {

class NoiseTiles {
 public:
  NoiseTiles(int width, int height);

  void count(std::size_t x, std::size_t y) noexcept {
    ++tiles_[(y >> shift_) * columns_ + (x >> shift_)].events;
  }

  // The counts of the last dt_s are in: brings the rate up to date.
  void update(float dt_s) noexcept;

  // Events counted per second and pixel where there are no objects.
  float rate_hz() const noexcept { return rate_hz_; }

  void clear() noexcept;

  std::size_t size() const noexcept { return tiles_.size(); }

 private:
  struct Tile {
    std::uint32_t events = 0;
    float rate_hz = 0;  // per pixel
    float pixels = 0;
  };

  int shift_;
  std::size_t columns_;
  std::vector<Tile> tiles_;
  std::vector<float> sorted_;
  float age_s_ = 0;
  float rate_hz_ = 0;
};

// The rate of all noise, per second and pixel, where `unsupported_hz` of it has no neighbour that
// fired within the window: unsupported = all exp(-8 all window).
float noise_with_support(float unsupported_hz, float window_s) noexcept;

// And of what has one.
float supported_noise(float noise_hz, float window_s) noexcept;

// How long ago a neighbour may have fired to be company: as long as the noise allows, because the
// pixels of a slow edge fire tens of ms apart, and at least `shortest_us`.
std::int32_t support_window_us(float noise_hz, std::int32_t shortest_us,
                               std::int32_t longest_us) noexcept;

}  // namespace asap::fast
