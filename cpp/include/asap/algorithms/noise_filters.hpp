// The filters that remove noise: BackgroundActivityFilter drops events without support,
// HotPixelMask those of hot pixels. One thread at a time. O(1) per event, no allocation after
// construction. They belong in front of the gamma filter.
//
//   BackgroundActivityFilter filter{{.width = 346, .height = 260}};
//   std::vector<Event> kept(events.size());
//   kept.resize(filter.process(events, std::span(kept)));
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

// ---- background activity -----------------------------------------------------------------------

// BackgroundActivityFilter: drops events without support. An event passes if one of its eight
// neighbours, of either polarity, fired at most `window` before it; its own pixel does not count.
// A rejected event still supports others. One thread. O(1) per event, no allocation
// after construction. Belongs in front of the gamma filter, which would remove the support.
// Source: Delbruck, "Frame-free dynamic digital vision", 2008.

struct BackgroundActivityFilterConfig {
  int width;                               // px
  int height;                              // px
  std::chrono::microseconds window{5000};  // 1 to 10 ms is usual
};

class BackgroundActivityFilter {
 public:
  using Config = BackgroundActivityFilterConfig;
  using Answer = std::uint8_t;

  // Rows around an event that its passing depends on.
  static constexpr int reach(const Config&) noexcept { return 1; }

  // Throws std::invalid_argument that names the bad field.
  explicit BackgroundActivityFilter(const Config& config);
  ~BackgroundActivityFilter();
  BackgroundActivityFilter(const BackgroundActivityFilter& other);
  BackgroundActivityFilter& operator=(const BackgroundActivityFilter& other);
  BackgroundActivityFilter(BackgroundActivityFilter&& other) noexcept;
  BackgroundActivityFilter& operator=(BackgroundActivityFilter&& other) noexcept;

  // Writes the events that pass to `out`, which holds at least events.size() (the tail beyond them
  // is scratch) and may be the events' own memory. Returns how many passed. Events outside the
  // frame do not pass and are counted.
  std::size_t process(EventSpan events, std::span<Event> out) noexcept;

  // Takes these events of a package that has `package`, and passes[i] is 1 where events[i] passes,
  // else 0. Throws std::invalid_argument if the sizes differ.
  void process(EventSpan events, std::span<Answer> passes, std::size_t package);

  // Tells the share of the next events that thinning kept, in [0, 1]: neighbours become as rare, so
  // the window grows by the mean of 1 / gamma over the latest events, to at most 500 s.
  void set_gamma(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// ---- hot pixels --------------------------------------------------------------------------------

// HotPixelMask: drops the events of hot pixels, which are given, found in a recording by learn(),
// or found on the way, among each learn_events events. A pixel is hot by the rule of `asap check`:
// kHotEvents events at least, one in kHotShare of all, and kHotFactor times as many as the second
// busiest of the 24 pixels around it (hot pixels come in pairs; a track passes at least two). What
// is masked stays masked until reset. One thread. O(1) per event, and one pass over the pixels per
// learn_events; no allocation after construction. Belongs in front of everything else.

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
  ~HotPixelMask();
  HotPixelMask(const HotPixelMask& other);
  HotPixelMask& operator=(const HotPixelMask& other);
  HotPixelMask(HotPixelMask&& other) noexcept;
  HotPixelMask& operator=(HotPixelMask&& other) noexcept;

  // Writes the events that pass to `out`, which holds at least events.size() (the tail beyond them
  // is scratch) and may be the events' own memory. Returns how many passed. Events outside the
  // frame do not pass and are counted.
  std::size_t process(EventSpan events, std::span<Event> out) noexcept;

  // Masks the hot pixels of these events too; returns how many they are. What was being learned on
  // the way starts again.
  std::size_t learn(EventSpan events) noexcept;

  // x < width, y < height.
  bool is_masked(std::uint32_t x, std::uint32_t y) const noexcept;

  // The masked pixels in reading order.
  std::vector<MaskedPixel> pixels() const;

  // The fraction of the events that reaches the mask, in [0, 1]. Checked, without effect: shares
  // stay what they are.
  void set_gamma(double gamma);

  // Back to the state after construction: what was learned is forgotten.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
