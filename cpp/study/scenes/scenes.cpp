#include "study/scenes/scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/check.hpp"
#include "study/scenes/draws.hpp"

namespace asap::scenes {
namespace {

constexpr double kMargin = 1.35;  // radii between a bounce and the frame

// Which of the many layouts of a seed: chosen so that seed 0 of A to E makes about as many events
// as the reference's one seed. Other seeds of C and E make up to 40 % more.
constexpr std::uint64_t kLayout = 3;
constexpr std::uint64_t kLayoutOfC = 31;
constexpr std::uint64_t kLayoutOfE = 8;

constexpr std::int32_t kWidth = 346;
constexpr std::int32_t kHeight = 260;

ShapeKind kind_of(std::int32_t number) noexcept {
  return static_cast<ShapeKind>(number % static_cast<std::int32_t>(RigidShape::kKinds));
}

Bounce bounce_before_frame(std::int32_t width, std::int32_t height, double radius_px) noexcept {
  return bounce_in(width, height, kMargin * radius_px);
}

MovingShape free_shape(const FreeShapes& scene, std::int32_t number, Draws& draws) noexcept {
  const double radius_px = draws.from(scene.radius_px);
  Bounce path = bounce_before_frame(scene.width, scene.height, radius_px);
  path.start = draws.in_box(path.low, path.high);
  path.velocity = draws.velocity(scene.speed_px_s);
  return {.kind = kind_of(number),
          .radius_px = radius_px,
          .brightness = brightness_of(number),
          .motion{.path = path,
                  .axis = draws.direction(),
                  .spin_rad_s = in_turn(number, scene.spin_rad_s)}};
}

MovingShapesConfig orbits(Range speed_px_s, double noise_hz, std::uint64_t seed) {
  constexpr std::int32_t kCount = 20;
  constexpr std::int32_t kColumns = 6;
  constexpr std::int32_t kRows = 4;
  Draws draws{seed, kLayout};
  MovingShapesConfig config{.noise_hz = noise_hz, .seed = seed};
  for (std::int32_t i = 0; i < kCount; ++i) {
    const double radius_px = draws.from({5.0, 9.0});
    const Orbit path{
        .centre{(i % kColumns + 0.5) * kWidth / kColumns, (i / kColumns + 0.5) * kHeight / kRows},
        .radius_px = 14.0,
        .speed_px_s = in_turn(i, draws.from(speed_px_s)),
        .phase = draws.direction()};
    config.shapes.push_back(
        {.kind = kind_of(i),
         .radius_px = radius_px,
         .brightness = brightness_of(i),
         .motion{.path = path, .axis = draws.direction(), .spin_rad_s = in_turn(i, 1.0)}});
  }
  return config;
}

MovingShapesConfig laid_out(const FreeShapes& scene, std::uint64_t layout) {
  const Range radius = scene.radius_px;
  const double room_px = (std::min(scene.width, scene.height) - 1.0) / (2.0 * kMargin);
  require(scene.count >= 0 && scene.count <= 10'000, "count", scene.count, "give 0 to 10000");
  require(radius.low >= 1.0 && radius.low <= radius.high, "radius_px", radius.low,
          "give at least 1 px, and no more than the upper end");
  require(radius.high <= room_px, "radius_px", radius.high,
          "give at most " + to_text(room_px) + " px, so that the shape has room on the sensor");
  require(scene.speed_px_s.low >= 0.0 && scene.speed_px_s.low <= scene.speed_px_s.high,
          "speed_px_s", scene.speed_px_s.low,
          "give 0 px/s or more, and no more than the upper end");
  require(scene.speed_px_s.high <= RigidMotion::kMaxSpeed_px_s, "speed_px_s", scene.speed_px_s.high,
          "give at most 2000 px/s");

  Draws draws{scene.seed, layout};
  MovingShapesConfig config{.width = scene.width,
                            .height = scene.height,
                            .duration_us = scene.duration_us,
                            .noise_hz = scene.noise_hz,
                            .seed = scene.seed};
  for (std::int32_t i = 0; i < scene.count; ++i) {
    config.shapes.push_back(free_shape(scene, i, draws));
  }
  return config;
}

template <class Scene>
void check_scripted(const Scene& scene) {
  require(scene.gap_us >= 0 && scene.gap_us <= 10'000'000, "gap_us", scene.gap_us,
          "give 0 to 10 s, in us");
  require(scene.speed_px_s >= 20.0 && scene.speed_px_s <= 1000.0, "speed_px_s", scene.speed_px_s,
          "give 20 to 1000 px/s");
  require(scene.radius_px >= 2.0 && scene.radius_px <= 20.0, "radius_px", scene.radius_px,
          "give 2 to 20 px");
}

std::int64_t whole_steps_us(double duration_us) noexcept {
  return static_cast<std::int64_t>(duration_us / MovingShapes::kStep_us) * MovingShapes::kStep_us;
}

}  // namespace

MovingShapesConfig free_shapes(const FreeShapes& scene) { return laid_out(scene, kLayout); }

MovingShapesConfig named(char name, std::uint64_t seed) {
  switch (name) {
    case 'A':
      return orbits({60.0, 120.0}, 0.5, seed);
    case 'B':
      return orbits({10.0, 400.0}, 0.5, seed);
    case 'C':
      return laid_out({.seed = seed}, kLayoutOfC);
    case 'D':
      return orbits({60.0, 120.0}, 5.0, seed);
    case 'E':
      return laid_out({.width = 240, .height = 180, .radius_px{6.0, 10.0}, .seed = seed},
                      kLayoutOfE);
    case 'F':
      return free_shapes({.radius_px{3.0, 20.0}, .speed_px_s{20.0, 600.0}, .seed = seed});
    case 'G':
      return free_shapes({.count = 30,
                          .width = 640,
                          .height = 480,
                          .radius_px{6.0, 14.0},
                          .speed_px_s{100.0, 250.0},
                          .noise_hz = 2.0,
                          .seed = seed});
    default:
      throw_bad_value("name", std::string(1, name), "give A to G");
  }
}

MovingShapesConfig stop_and_go(const StopAndGo& scene) {
  check_scripted(scene);
  FreeShapes one{.count = 1,
                 .duration_us = whole_steps_us(2.0 * kStop_us + static_cast<double>(scene.gap_us)),
                 .radius_px{scene.radius_px, scene.radius_px},
                 .speed_px_s{scene.speed_px_s, scene.speed_px_s},
                 .noise_hz = scene.noise_hz,
                 .seed = scene.seed};
  MovingShapesConfig config = free_shapes(one);
  config.shapes[0].kind = kind_of(static_cast<std::int32_t>(scene.seed % RigidShape::kKinds));
  config.shapes[0].motion.pause = {kStop_us, kStop_us + scene.gap_us};
  return config;
}

MovingShapesConfig occlusion(const Occlusion& scene) {
  check_scripted(scene);
  Draws draws{scene.seed, kLayout};
  const ShapeKind kind = kind_of(static_cast<std::int32_t>(scene.seed % RigidShape::kKinds));
  const double reach_px = RigidShape(kind, scene.radius_px).reach_px();
  const double hidden_px = scene.speed_px_s * 1e-6 * static_cast<double>(scene.gap_us);
  const double half_side_px = 0.5 * hidden_px + reach_px;
  require(half_side_px <= 0.25 * kWidth, "gap_us", scene.gap_us,
          "give less: at this speed and radius the square that hides the shape takes more than "
          "half the view");

  Bounce path = bounce_before_frame(kWidth, kHeight, scene.radius_px);
  const bool to_the_right = draws.from({0.0, 1.0}) < 0.5;
  const PlanePoint middle{0.5 * (kWidth - 1), 0.5 * (kHeight - 1)};
  path.start = {to_the_right ? path.low.x : path.high.x,
                middle.y + draws.from({-0.5, 0.5}) * (half_side_px - reach_px)};
  path.velocity = {to_the_right ? scene.speed_px_s : -scene.speed_px_s, 0.0};
  const double crossing_us = 1e6 * (path.high.x - path.low.x) / scene.speed_px_s;

  const Bounce rest{.start = middle, .velocity{}, .low = middle, .high = middle};
  return {.duration_us = whole_steps_us(crossing_us),
          .noise_hz = scene.noise_hz,
          .seed = scene.seed,
          .shapes{{.kind = kind,
                   .radius_px = scene.radius_px,
                   .brightness = kDark,
                   .motion{.path = path, .axis = draws.direction(), .spin_rad_s = 1.0}},
                  {.kind = ShapeKind::kSquare,
                   .radius_px = half_side_px,
                   .brightness = kBright,
                   .motion{.path = rest}}}};
}

}  // namespace asap::scenes
