// Event streams for the tests and benchmarks of corner detectors and filters.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "asap/core/event.hpp"
#include "core/random.hpp"

namespace asap::test {

// Stream S2 of the golden vectors: six squares of 40 px, one polarity per side, that swing in a
// 346 x 260 frame, one event every 10 us, a sixteenth of them noise.
inline std::vector<Event> golden_corner_stream(std::size_t count = 200'000) {
  std::uint64_t state = 88172645463325252U;
  const auto next = [&state] {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state >> 32;
  };
  const auto triangle = [](std::uint64_t a, std::int64_t m) {
    return static_cast<std::uint64_t>(std::abs(static_cast<std::int64_t>(a) % (2 * m) - m));
  };

  std::vector<Event> events;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t u = next();
    std::uint64_t x = 0;
    std::uint64_t y = 0;
    std::uint64_t p = 0;
    if (u % 16 == 0) {
      x = next() % 346;
      y = next() % 260;
      p = next() % 2;
    } else {
      const std::uint64_t k = (u / 16) % 6;
      x = 30 + 100 * (k % 3) + triangle(i / 150 + 17 * k, 25);
      y = 30 + 110 * (k / 3) + triangle(i / 210 + 29 * k, 25);
      const std::uint64_t q = next() % 160;
      const std::uint64_t a = q % 40;
      switch (q / 40) {
        case 0:
          x += a;
          p = 1;
          break;
        case 1:
          x += 40;
          y += a;
          break;
        case 2:
          x += 40 - a;
          y += 40;
          break;
        default:
          y += 40 - a;
          p = 1;
          break;
      }
    }
    events.push_back({.x = static_cast<std::uint16_t>(x),
                      .y = static_cast<std::uint16_t>(y),
                      .p = static_cast<std::int16_t>(p),
                      .t = static_cast<std::int64_t>(10 * (i + 1))});
  }
  return events;
}

// Eight turning polygons of radius 12 to 26 px that bounce in a 346 x 260 frame: the streams on
// which the corner detectors are timed.
struct TurningShapes {
  double speed = 120;   // px/s
  double noise_hz = 0;  // per pixel
};

inline std::vector<Event> turning_shapes(const TurningShapes& scene, std::size_t count) {
  constexpr double kWidth = 346;
  constexpr double kHeight = 260;
  constexpr double kDensity = 3.4;  // events per pixel of edge and pixel of motion across it
  constexpr int kShapes = 8;
  struct Shape {
    double x, y, vx, vy, r, turn, sides;
  };
  const CounterRandom random(5);
  std::uint64_t draws = 0;
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * random.uniform(draws++);
  };
  const double spin_share = 0.4;  // of the speed, at the vertices
  const double fastest = scene.speed * (1 + spin_share);

  std::vector<Shape> shapes;
  for (int i = 0; i < kShapes; ++i) {
    const double heading = uniform(0, 2 * std::numbers::pi);
    const double r = uniform(12, 26);
    shapes.push_back({.x = uniform(r, kWidth - r),
                      .y = uniform(r, kHeight - r),
                      .vx = scene.speed * std::cos(heading),
                      .vy = scene.speed * std::sin(heading),
                      .r = r,
                      .turn = (i % 2 == 0 ? spin_share : -spin_share) * scene.speed / r,
                      .sides = 3.0 + i % 3});
  }
  // Candidates as if all edges had this length and the largest speed; thinned to what they have.
  const double longest = 2 * 26 * 3.0;
  const double shape_rate = longest * fastest * kDensity;
  const double noise_rate = scene.noise_hz * kWidth * kHeight;
  const double rate = kShapes * shape_rate + noise_rate;

  std::vector<Event> events;
  double t = 0;  // s
  while (events.size() < count) {
    t += -std::log(1 - uniform(0, 1)) / rate;
    double x = uniform(0, kWidth);
    double y = uniform(0, kHeight);
    bool on = uniform(0, 1) < 0.5;
    const double choice = uniform(0, rate);
    if (choice >= noise_rate) {
      const auto number = std::min<std::size_t>(
          kShapes - 1, static_cast<std::size_t>((choice - noise_rate) / shape_rate));
      const Shape& shape = shapes[number];
      // A coordinate that runs there and back between the borders.
      const auto bounced = [&](double start, double v, double size, double& direction) {
        const double span = size - 2 * shape.r;
        const double path =
            std::fmod(std::fmod(start - shape.r + v * t, 2 * span) + 2 * span, 2 * span);
        direction = path < span ? 1 : -1;
        return shape.r + (path < span ? path : 2 * span - path);
      };
      double flip_x = 1;
      double flip_y = 1;
      const double centre_x = bounced(shape.x, shape.vx, kWidth, flip_x);
      const double centre_y = bounced(shape.y, shape.vy, kHeight, flip_y);
      const double half = std::numbers::pi / shape.sides;
      const double edge = std::floor(uniform(0, shape.sides));
      const double normal = shape.turn * t + (2 * edge + 1) * half;
      const double along = uniform(-1, 1) * shape.r * std::sin(half);
      const double offset = shape.r * std::cos(half);
      const double dx = offset * std::cos(normal) - along * std::sin(normal);
      const double dy = offset * std::sin(normal) + along * std::cos(normal);
      const double vx = flip_x * shape.vx - shape.turn * dy;
      const double vy = flip_y * shape.vy + shape.turn * dx;
      const double across = vx * std::cos(normal) + vy * std::sin(normal);
      const double perimeter = shape.sides * 2 * shape.r * std::sin(half);
      if (uniform(0, 1) * longest * fastest > perimeter * std::abs(across)) continue;
      x = centre_x + dx;
      y = centre_y + dy;
      on = across > 0;
    }
    if (x < 0 || y < 0 || x >= kWidth || y >= kHeight) continue;
    events.push_back({.x = static_cast<std::uint16_t>(x),
                      .y = static_cast<std::uint16_t>(y),
                      .p = static_cast<std::int16_t>(on),
                      .t = static_cast<std::int64_t>(t * 1e6)});
  }
  return events;
}

// A square that wanders over the whole frame and beyond its borders, with noise. Steps of time are
// 0 to 40 us, most of them 0, and now and then as long as `pause_us`.
struct WildStream {
  int width = 40;
  int height = 30;
  std::int64_t start_us = 0;
  std::int64_t pause_us = 60'000;
  std::uint64_t seed = 1;
};

inline std::vector<Event> wild_stream(const WildStream& stream, std::size_t count) {
  const CounterRandom random(stream.seed);
  std::vector<Event> events;
  std::int64_t t = stream.start_us;
  for (std::uint64_t i = 0; events.size() < count; ++i) {
    const std::uint64_t bits = random(2 * i);
    const std::uint64_t place = random(2 * i + 1);
    if (bits % 4 == 0) t += static_cast<std::int64_t>((bits >> 8) % 41);
    if (bits % 4096 == 1) t += stream.pause_us;
    std::int64_t x = static_cast<std::int64_t>(place % static_cast<std::uint64_t>(stream.width));
    std::int64_t y =
        static_cast<std::int64_t>((place >> 20) % static_cast<std::uint64_t>(stream.height));
    if ((bits >> 16) % 8 != 0) {
      constexpr std::int64_t kSide = 12;
      const auto step = static_cast<std::int64_t>(i);
      const std::int64_t along = static_cast<std::int64_t>((place >> 40) % kSide);
      x = std::abs((step / 60) % (2 * stream.width) - stream.width) - kSide / 2;
      y = std::abs((step / 90) % (2 * stream.height) - stream.height) - kSide / 2;
      switch ((place >> 60) % 4) {
        case 0:
          x += along;
          break;
        case 1:
          x += kSide;
          y += along;
          break;
        case 2:
          x += kSide - along;
          y += kSide;
          break;
        default:
          y += kSide - along;
          break;
      }
    }
    if (x < 0 || y < 0 || x >= stream.width || y >= stream.height) continue;
    events.push_back({.x = static_cast<std::uint16_t>(x),
                      .y = static_cast<std::uint16_t>(y),
                      .p = static_cast<std::int16_t>((bits >> 32) % 8 < 6),
                      .t = t});
  }
  return events;
}

// What is hard for time and border: equal stamps, silences, any sign, jumps of hours and of
// centuries, frames that hardly hold a ring.
inline std::vector<WildStream> wild_streams() {
  constexpr std::int64_t kHour = 3'600'000'000;
  return {{.seed = 1},
          {.start_us = 1'600'000'000'000'000, .seed = 2},
          {.start_us = -1'000'000, .seed = 3},
          {.start_us = -7 * kHour, .pause_us = kHour, .seed = 4},
          {.start_us = std::numeric_limits<std::int64_t>::min(),
           .pause_us = std::numeric_limits<std::int64_t>::max() / 16,
           .seed = 5},
          {.width = 9, .height = 10, .seed = 6},
          {.width = 346, .height = 5, .seed = 7},
          {.width = 1, .height = 1, .seed = 8}};
}

// 32-bit FNV-1a, the hash of the golden vectors.
inline std::uint32_t hash_of(std::span<const std::uint8_t> labels) {
  std::uint32_t hash = 2166136261U;
  for (const std::uint8_t label : labels) hash = (hash ^ label) * 16777619U;
  return hash;
}

}  // namespace asap::test
