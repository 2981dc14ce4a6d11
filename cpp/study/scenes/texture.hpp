// Texture: a smooth random pattern without end, of which a moving shape may be made. MovingGround:
// the pattern behind the shapes, seen by a camera that turns, zooms and shifts about the middle of
// the view. Deterministic, + - * / only (see event_stream.hpp). One thread; O(1) per point, O(1)
// per step; allocates in the constructors only.
#pragma once

#include <cstdint>
#include <vector>

#include "core/random.hpp"
#include "synthetic/plane.hpp"

namespace asap {

// Values at the points of a square lattice, uniform from `low` to `high`; between them bilinear.
// The lattice repeats after 64 points.
class Texture {
 public:
  Texture(CounterRandom random, double pitch_px, double low, double high);

  double at(PlanePoint point) const noexcept;

 private:
  double inverse_pitch_;
  std::vector<double> values_;
};

struct MovingGroundConfig {
  double pitch_px = 6.0;
  double low = 0.1;  // brightness
  double high = 0.9;
  PlanePoint shift_px_s{};
  double turn_rad_s = 0.0;
  double zoom_per_s = 0.0;  // growth of the pattern
};

class MovingGround {
 public:
  MovingGround(const MovingGroundConfig& config, std::int32_t width, std::int32_t height,
               CounterRandom random);

  // The brightness that a pixel sees now.
  double brightness(std::int32_t x, std::int32_t y) const noexcept;

  // Where the pattern that was at this pixel at the start is now.
  PlanePoint moved(PlanePoint start) const noexcept;

  void advance(std::int32_t step_us) noexcept;

 private:
  MovingGroundConfig config_;
  Texture texture_;
  PlanePoint middle_;
  PlanePoint shift_{};  // px, in the pattern
  UnitVector axis_{};
  double scale_ = 1.0;
};

}  // namespace asap
