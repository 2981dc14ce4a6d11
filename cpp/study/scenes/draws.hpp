// Draws: the random numbers of a scene's layout, one after the other; and what the layouts share.
// One thread, O(1), no allocation; + - * / and sqrt only (see event_stream.hpp).
#pragma once

#include <cmath>
#include <cstdint>

#include "core/random.hpp"
#include "study/scenes/rigid_motion.hpp"

namespace asap::scenes {

inline constexpr double kDark = 0.08;
inline constexpr double kBright = 0.95;

inline double brightness_of(std::int32_t number) noexcept {
  return number % 2 == 0 ? kDark : kBright;
}

inline double in_turn(std::int32_t number, double value) noexcept {
  return number % 2 == 0 ? value : -value;
}

// A box that keeps centres so far from the frame.
inline Bounce bounce_in(std::int32_t width, std::int32_t height, double margin_px) noexcept {
  return {.start{},
          .velocity{},
          .low{margin_px, margin_px},
          .high{width - 1.0 - margin_px, height - 1.0 - margin_px}};
}

struct Range {
  double low;
  double high;
};

class Draws {
 public:
  // `layout`: of a seed has many.
  Draws(std::uint64_t seed, std::uint64_t layout) noexcept : random_(CounterRandom(seed)(layout)) {}

  double from(Range range) noexcept {
    return range.low + (range.high - range.low) * random_.uniform(drawn_++);
  }

  PlanePoint in_box(PlanePoint low, PlanePoint high) noexcept {
    const double x = from({low.x, high.x});
    return {x, from({low.y, high.y})};
  }

  // Uniform in angle: points of the unit disk.
  UnitVector direction() noexcept {
    for (;;) {
      const PlanePoint point = in_box({-1.0, -1.0}, {1.0, 1.0});
      const double length = std::sqrt(point.x * point.x + point.y * point.y);
      if (length > 0.1 && length <= 1.0) return {point.x / length, point.y / length};
    }
  }

  PlanePoint velocity(Range speed_px_s) noexcept {
    const double speed = from(speed_px_s);
    const UnitVector towards = direction();
    return {speed * towards.x, speed * towards.y};
  }

 private:
  CounterRandom random_;
  std::uint64_t drawn_ = 0;
};

}  // namespace asap::scenes
