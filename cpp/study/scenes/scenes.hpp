// The scenes with truth by which trackers are judged, as configurations of MovingShapes: A to G,
// free shapes (timing and corner scenes), and two scripted ones, stop-and-go and occlusion. Shape i
// is disk, square, rectangle, triangle, star in turn, dark if i is even, bright if odd. Functions
// of their arguments alone; a bad one is refused with its name, value and remedy.
#pragma once

#include <cstdint>

#include "study/scenes/draws.hpp"
#include "study/scenes/moving_shapes.hpp"

namespace asap::scenes {

// Straight ahead, bouncing 1.35 radii before the frame.
struct FreeShapes {
  std::int32_t count = 8;
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::int64_t duration_us = 2'000'000;
  Range radius_px{7.0, 11.0};
  Range speed_px_s{80.0, 200.0};
  double spin_rad_s = 1.0;  // in turn this way and that
  double noise_hz = 0.5;
  std::uint64_t seed = 0;
};
MovingShapesConfig free_shapes(const FreeShapes& scene);

// 'A' to 'G'. A, B and D: 20 shapes on small orbits, slow, of mixed speed, noisy; C and E: crossing
// shapes; F: of very different size and speed; G: many, on a larger and noisier sensor.
MovingShapesConfig named(char name, std::uint64_t seed = 0);

// A shape that moves 0.7 s, stands still for the gap, and moves on for 0.7 s.
struct StopAndGo {
  std::int64_t gap_us = 300'000;
  double speed_px_s = 150.0;
  double radius_px = 8.0;
  double noise_hz = 0.5;
  std::uint64_t seed = 0;
};
constexpr std::int64_t kStop_us = 700'000;
MovingShapesConfig stop_and_go(const StopAndGo& scene);

// Shape 0 crosses the view and is hidden for the gap behind shape 1, a bright square at rest.
struct Occlusion {
  std::int64_t gap_us = 300'000;
  double speed_px_s = 150.0;
  double radius_px = 8.0;
  double noise_hz = 0.5;
  std::uint64_t seed = 0;
};
MovingShapesConfig occlusion(const Occlusion& scene);

}  // namespace asap::scenes
