#include "study/scenes/large_scenes.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "core/check.hpp"
#include "study/scenes/draws.hpp"

namespace asap::scenes {
namespace {

constexpr std::uint64_t kLargeLayout = 5;
constexpr std::int32_t kLargeWidth = 240;
constexpr std::int32_t kLargeHeight = 180;
constexpr std::int64_t kDuration_us = 2'000'000;
constexpr double kNoise_hz = 1.0;
constexpr Range kSpin_rad_s{0.2, 1.0};

MovingShapesConfig view(std::int32_t width, std::int32_t height, std::uint64_t seed) {
  return {.width = width,
          .height = height,
          .duration_us = kDuration_us,
          .noise_hz = kNoise_hz,
          .seed = seed};
}

// The centre turns back at half the shape's reach from the frame, so that the objects have the
// whole view.
MovingShape wanderer(MovingShape shape, const MovingShapesConfig& in, Range speed_px_s,
                     std::int32_t number, Draws& draws) {
  Bounce path = bounce_in(in.width, in.height, 0.5 * reach_px(shape));
  path.start = draws.in_box(path.low, path.high);
  path.velocity = draws.velocity(speed_px_s);
  shape.motion = {.path = path,
                  .axis = draws.direction(),
                  .spin_rad_s = in_turn(number, draws.from(kSpin_rad_s))};
  shape.brightness = brightness_of(number);
  return shape;
}

MovingShape large_shape(ShapeKind kind, Draws& draws) {
  switch (kind) {
    case ShapeKind::kBar:
      return {.kind = kind,
              .radius_px = 0.5 * draws.from({60.0, 90.0}),
              .thickness_px = draws.from({8.0, 14.0})};
    case ShapeKind::kAngle:
      return {.kind = kind, .radius_px = 40.0, .thickness_px = draws.from({8.0, 14.0})};
    case ShapeKind::kRing:
      return {.kind = kind,
              .radius_px = draws.from({14.0, 30.0}),
              .thickness_px = draws.from({3.0, 6.0})};
    default:
      throw_bad_value("kind", std::to_string(static_cast<int>(kind)), "give bars, angles or rings");
  }
}

MovingShape hand(Draws& draws) {
  constexpr double kPalm_px = 27.5;
  constexpr double kFingers = 5.0;
  constexpr double kBetween = 0.26;  // tan of half the angle from a finger to the next
  MovingShape palm{.radius_px = kPalm_px};
  UnitVector direction = UnitVector{}.turned(-kBetween).turned(-kBetween);
  for (double finger = 0.0; finger < kFingers; finger += 1.0) {
    constexpr double kJoint_px = kPalm_px - 4.0;  // no gap opens when the finger waves
    palm.limbs.push_back({.length_px = draws.from({24.0, 34.0}),
                          .width_px = draws.from({7.0, 10.0}),
                          .joint{kJoint_px * direction.x, kJoint_px * direction.y},
                          .direction = direction,
                          .swing_rad = draws.from({0.2, 0.4}),
                          .rate_hz = draws.from({1.0, 3.0}),
                          .phase = draws.direction()});
    direction = direction.turned(kBetween);
  }
  return palm;
}

// A disk, a square, a rectangle or a triangle of this size.
MovingShape sized_shape(std::uint64_t number, double size_px) {
  const auto kind = static_cast<ShapeKind>(number % 4);
  return {.kind = kind, .radius_px = 0.5 * size_px / RigidShape(kind, 1.0).reach_px()};
}

void add_small_movers(MovingShapesConfig& config, std::int32_t count, Draws& draws) {
  for (std::int32_t i = 0; i < count; ++i) {
    const MovingShape mover{.kind = i % 2 == 0 ? ShapeKind::kDisk : ShapeKind::kSquare,
                            .radius_px = draws.from({5.0, 10.0})};
    config.shapes.push_back(wanderer(mover, config, {80.0, 200.0}, i, draws));
  }
}

MovingShape at_rest(MovingShape shape, PlanePoint place) {
  shape.brightness = kBright;
  shape.motion.path = Bounce{.start = place, .velocity{}, .low = place, .high = place};
  return shape;
}

}  // namespace

MovingShapesConfig large_shapes(std::span<const ShapeKind> kinds, std::uint64_t seed) {
  constexpr std::int32_t kCount = 6;
  require(!kinds.empty(), "kinds", kinds.size(), "give one or more");
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(kLargeWidth, kLargeHeight, seed);
  for (std::int32_t i = 0; i < kCount; ++i) {
    const ShapeKind kind = kinds[static_cast<std::size_t>(i) % kinds.size()];
    config.shapes.push_back(wanderer(large_shape(kind, draws), config, {60.0, 400.0}, i, draws));
  }
  return config;
}

MovingShapesConfig large_disks(std::uint64_t seed) {
  constexpr std::int32_t kCount = 6;
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(346, 260, seed);
  for (std::int32_t i = 0; i < kCount; ++i) {
    MovingShape disk{.radius_px = draws.from({14.0, 34.0}), .textured = (i + 1) / 2 % 2 == 1};
    config.shapes.push_back(wanderer(disk, config, {60.0, 200.0}, i, draws));
  }
  return config;
}

MovingShapesConfig hands(std::uint64_t seed) {
  constexpr std::int32_t kCount = 2;
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(346, 260, seed);
  for (std::int32_t i = 0; i < kCount; ++i) {
    config.shapes.push_back(wanderer(hand(draws), config, {50.0, 200.0}, i, draws));
  }
  return config;
}

MovingShapesConfig moving_camera(std::uint64_t seed) {
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(kLargeWidth, kLargeHeight, seed);
  config.duration_us = 1'000'000;
  const auto count = static_cast<std::int32_t>(2 + seed % 2);
  for (std::int32_t i = 0; i < count; ++i) {
    MovingShape mover{.kind = i % 2 == 0 ? ShapeKind::kDisk : ShapeKind::kSquare,
                      .radius_px = draws.from({5.0, 20.0})};
    config.shapes.push_back(wanderer(mover, config, {120.0, 300.0}, i, draws));
  }
  config.ground = MovingGroundConfig{.shift_px_s = draws.velocity({20.0, 80.0}),
                                     .turn_rad_s = in_turn(count, draws.from({0.1, 0.4})),
                                     .zoom_per_s = draws.from({0.0, 0.3})};
  return config;
}

MovingShapesConfig sparse(std::uint64_t seed) {
  constexpr std::int32_t kCount = 3;
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(346, 260, seed);
  config.noise_hz = draws.from({0.1, 0.5});
  for (std::int32_t i = 0; i < kCount; ++i) {
    const double size_px = draws.from({40.0, 130.0});
    const double ratio = draws.from({1.34, 1.43});
    const double speed_px_s = draws.from({2800.0, 5600.0}) / size_px;
    MovingShape mover = wanderer(sized_shape(seed + static_cast<std::uint64_t>(i), size_px), config,
                                 {speed_px_s, speed_px_s}, i, draws);
    mover.motion.spin_rad_s *= 0.2;
    auto& path = std::get<Bounce>(mover.motion.path);  // in a third of its own at the start
    path.start.x = path.low.x + draws.from({i / 3.0, (i + 1) / 3.0}) * (path.high.x - path.low.x);
    mover.brightness = i % 2 == 0 ? MovingShapes::kGround / ratio : MovingShapes::kGround * ratio;
    config.shapes.push_back(std::move(mover));
  }
  return config;
}

MovingShapesConfig approaching(std::uint64_t seed) {
  constexpr double kNearest_px = 50.0;
  constexpr double kFactor = 10.0;
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(346, 260, seed);
  const auto count = static_cast<std::int32_t>(2 + seed % 2);
  add_small_movers(config, count, draws);
  const MovingShape near{
      .kind = draws.from({0.0, 1.0}) < 0.5 ? ShapeKind::kDisk : ShapeKind::kSquare,
      .radius_px = kNearest_px};
  MovingShape comer = wanderer(near, config, {20.0, 80.0}, count, draws);
  comer.radius_px = kNearest_px / kFactor;
  comer.motion.growth = {kFactor, static_cast<std::int64_t>(draws.from({1e6, 1.8e6}))};
  config.shapes.push_back(std::move(comer));
  return config;
}

MovingShapesConfig lamps(std::uint64_t seed) {
  constexpr std::int32_t kMovers = 4;
  constexpr std::int64_t kPeriods_us[] = {20'000, 10'000, 1'000};
  constexpr std::size_t kLamps = std::size(kPeriods_us);
  constexpr std::size_t kPairs = 2;
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(346, 260, seed);
  add_small_movers(config, kMovers, draws);
  double left_px = 0.0;
  for (const std::int64_t period_us : kPeriods_us) {
    constexpr double kColumn_px = 346.0 / kLamps;  // one each, so that they lie apart
    MovingShape lamp{.kind = draws.from({0.0, 1.0}) < 0.5 ? ShapeKind::kDisk : ShapeKind::kSquare,
                     .radius_px = draws.from({3.0, 8.0})};
    lamp.flicker = {period_us,
                    static_cast<std::int64_t>(draws.from({0.0, static_cast<double>(period_us)}))};
    const PlanePoint place =
        draws.in_box({left_px + 10.0, 10.0}, {left_px + kColumn_px - 10.0, 249.0});
    config.shapes.push_back(at_rest(lamp, place));
    left_px += kColumn_px;
  }
  for (std::size_t i = 0; i < kPairs; ++i) {
    const PlanePoint place = draws.in_box({0.0, 0.0}, {345.0, 260.0});
    MovingShape pair{.kind = ShapeKind::kRectangle, .radius_px = 1.0};  // 2 x 1 px
    pair.flicker = {2'000, static_cast<std::int64_t>(draws.from({0.0, 2'000.0}))};
    config.shapes.push_back(at_rest(pair, {std::floor(place.x) + 0.5, std::floor(place.y)}));
  }
  config.decoys = kLamps + kPairs;
  return config;
}

MovingShapesConfig fence(std::uint64_t seed) {
  constexpr UnitVector kVertical{1.0, 0.0};
  constexpr UnitVector kFalling{0.8, 0.6};
  constexpr UnitVector kRising{0.8, -0.6};
  Draws draws{seed, kLargeLayout};
  MovingShapesConfig config = view(346, 260, seed);
  const MovingShape ball{.radius_px = draws.from({15.0, 40.0})};
  config.shapes.push_back(
      wanderer(ball, config, {100.0, 250.0}, static_cast<std::int32_t>(seed % 2), draws));
  FenceConfig wires{.pitch_px = draws.from({10.0, 20.0}), .wire_px = draws.from({3.0, 6.0})};
  switch (seed % 3) {
    case 0:
      wires.across = {kVertical};
      break;
    case 1:
      wires.across = {kFalling};
      break;
    default:
      wires.across = {kFalling, kRising};
  }
  config.fence = std::move(wires);
  return config;
}

}  // namespace asap::scenes
