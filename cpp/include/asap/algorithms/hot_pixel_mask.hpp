// HotPixelMask: drops the events of hot pixels, which are given, found in a recording by learn(),
// or found on the way, among each learn_events events. A pixel is hot by the rule of `asap check`:
// kHotEvents events at least, one in kHotShare of all, and kHotFactor times as many as the second
// busiest of the 24 pixels around it (hot pixels come in pairs; a track passes at least two). What
// is masked stays masked until reset. One thread. O(1) per event, and one pass over the pixels per
// learn_events; no allocation after construction. Belongs in front of everything else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/algorithms/sensor_frame.hpp"
#include "asap/core/event.hpp"

namespace asap {

struct MaskedPixel {
  int x;  // px
  int y;  // px

  friend bool operator==(const MaskedPixel&, const MaskedPixel&) = default;
};

struct HotPixelMaskConfig {
  int width;                             // px
  int height;                            // px
  std::vector<MaskedPixel> pixels = {};  // masked from the beginning
  std::int64_t learn_events = 100'000;   // 0: no pixel is found on the way
};

class HotPixelMask {
 public:
  using Config = HotPixelMaskConfig;
  static constexpr std::uint64_t kHotEvents = 100;
  static constexpr std::uint64_t kHotShare = 1000;
  static constexpr std::uint64_t kHotFactor = 5;

  // Throws std::invalid_argument that names the bad field.
  explicit HotPixelMask(const Config& config);

  // Writes the events that pass to `out`, which holds at least events.size() (the tail beyond them
  // is scratch) and may be the events' own memory. Returns how many passed. Events outside the
  // frame do not pass and are counted.
  std::size_t process(EventSpan events, Event* out) noexcept;

  // Masks the hot pixels of these events too; returns how many they are. What was being learned on
  // the way starts again.
  std::size_t learn(EventSpan events) noexcept;

  // x < width, y < height.
  bool is_masked(std::uint32_t x, std::uint32_t y) const noexcept {
    return (cells_[index(x, y)] & kMasked) != 0;
  }

  // In reading order.
  std::vector<MaskedPixel> pixels() const;

  // The fraction of the events that reaches the mask, in [0, 1]. Checked, without effect: shares
  // stay what they are.
  void set_keep(double gamma);

  // Back to the state after construction: what was learned is forgotten.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  using Cell = std::uint32_t;
  static constexpr Cell kMasked = Cell{1} << 31;  // the bits below count events
  static constexpr std::uint32_t kReach = 2;      // px around a pixel that are its neighbours

  std::size_t index(std::uint32_t x, std::uint32_t y) const noexcept {
    return y * stride_ + x + first_;
  }
  void mask_given() noexcept;
  void forget_counts() noexcept;
  std::size_t mask_hot() noexcept;
  bool is_hot(const Cell* cell) const noexcept;

  Config config_;
  SensorFrame frame_;
  std::size_t stride_;
  std::size_t first_;        // index of the first pixel
  std::vector<Cell> cells_;  // a border of kReach pixels lies around the frame
  std::uint64_t counted_ = 0;
  std::uint64_t rejected_ = 0;
};

}  // namespace asap
