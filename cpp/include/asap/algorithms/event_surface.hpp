// EventSurface: a surface that every event changes around its pixel: ThresholdOrdinalSurface (TOS)
// and SpeedInvariantTimeSurface (SITS). Blind to timestamps and polarity: what counts is the order
// of the events. One thread at a time. O(1) per event; no allocation after construction.
//
//   ThresholdOrdinalSurface surface{{.width = 346, .height = 260}};
//   surface.process(events);
//   const std::uint8_t newest = surface.at(173, 130);  // 255: the last event around was here
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <span>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

struct ThresholdOrdinalSurfaceConfig {
  int width;     // px
  int height;    // px
  int side = 7;  // px of the window, odd
};

struct SpeedInvariantTimeSurfaceConfig {
  int width;       // px
  int height;      // px
  int radius = 6;  // px; the window is 2 radius + 1 wide
};

template <class Rule, class Configuration, class Pixel>
class EventSurface {
 public:
  using Config = Configuration;
  using Value = Pixel;

  // Rows around an event that it changes. A rank depends on ranks that depend on others, without
  // end.
  static constexpr int reach(const ThresholdOrdinalSurfaceConfig& config) noexcept
    requires std::same_as<Config, ThresholdOrdinalSurfaceConfig>
  {
    return config.side / 2;
  }

  // Throws std::invalid_argument that names the bad field.
  explicit EventSurface(const Config& config);
  ~EventSurface();
  EventSurface(const EventSurface& other);
  EventSurface& operator=(const EventSurface& other);
  EventSurface(EventSurface&& other) noexcept;
  EventSurface& operator=(EventSurface&& other) noexcept;

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // x < width, y < height.
  Value at(std::uint32_t x, std::uint32_t y) const noexcept;

  // The surface row by row. Throws std::invalid_argument unless out.size() is width x height.
  void copy_to(std::span<Value> out) const;

  // The fraction of the events that reaches the surface, in [0, 1]. Checked, without effect: the
  // published rules age by the events of the neighbourhood and hold no rate to correct.
  void set_gamma(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  Config config_;
  std::unique_ptr<Rule> rule_;
  std::uint64_t rejected_ = 0;
};

// How recently each pixel fired, counted in events of its neighbourhood, in 8 bits. An event takes
// 1 from every pixel of the side x side window around it, to 0 what thereby falls below 255 - 2
// side, and sets its own to 255. So the surface shows edges with the same width at any speed.
// Source: Glover, Dinale, De Souza Rosa, Bamford, Bartolozzi, "luvHarris: A Practical Corner
// Detector for Event-Cameras", TPAMI 2021. Public releases clear from one value lower.
class ThresholdOrdinalRule;
extern template class EventSurface<ThresholdOrdinalRule, ThresholdOrdinalSurfaceConfig,
                                   std::uint8_t>;
using ThresholdOrdinalSurface =
    EventSurface<ThresholdOrdinalRule, ThresholdOrdinalSurfaceConfig, std::uint8_t>;

// The order in which the pixels of a neighbourhood fired, as ranks from (2 radius + 1)^2, the
// newest, down to 0, independent of speed. An event takes 1 from every pixel of the window around
// it that ranks above its own, and sets its own to the top.
// Source: Manderscheid, Sironi, Bourdis, Migliore, Lepetit, "Speed Invariant Time Surface for
// Learning to Detect Corner Points with Event-Based Cameras", CVPR 2019, algorithm 1, with one
// surface for both polarities.
class SpeedInvariantTimeRule;
extern template class EventSurface<SpeedInvariantTimeRule, SpeedInvariantTimeSurfaceConfig,
                                   std::uint16_t>;
using SpeedInvariantTimeSurface =
    EventSurface<SpeedInvariantTimeRule, SpeedInvariantTimeSurfaceConfig, std::uint16_t>;

}  // namespace asap::inline v0_1
