// Event streams for the tests and the benchmark of the clusterer: repeatable, no camera needed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "asap/core/event.hpp"
#include "core/random.hpp"

namespace asap::test {

// Stream S1 of the golden vectors: ten squares of 13 px that swing in a 346 x 260 frame, one event
// every 10 us, an eighth of them noise.
inline std::vector<Event> golden_stream(std::size_t count = 20'000) {
  std::uint64_t state = 88172645463325252U;
  const auto next = [&state] {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state >> 32;
  };
  const auto triangle = [](std::uint64_t a, std::int64_t m) {
    return std::abs(static_cast<std::int64_t>(a) % (2 * m) - m);
  };

  std::vector<Event> events;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t u = next();
    std::int64_t x = 0;
    std::int64_t y = 0;
    if (u % 8 == 0) {
      x = static_cast<std::int64_t>(next() % 346);
      y = static_cast<std::int64_t>(next() % 260);
    } else {
      const std::uint64_t k = (u / 8) % 10;
      const auto centre_x =
          static_cast<std::int64_t>(40 + 60 * (k % 5)) + triangle(i / 40 + 37 * k, 20);
      const auto centre_y =
          static_cast<std::int64_t>(60 + 130 * (k / 5)) + triangle(i / 55 + 11 * k, 20);
      x = centre_x + static_cast<std::int64_t>(next() % 13) - 6;
      y = centre_y + static_cast<std::int64_t>(next() % 13) - 6;
    }
    const std::uint64_t p = next() % 2;
    events.push_back({.x = static_cast<std::uint16_t>(x),
                      .y = static_cast<std::uint16_t>(y),
                      .p = static_cast<std::int16_t>(p),
                      .t = static_cast<std::int64_t>(10 * i)});
  }
  return events;
}

// Discs that bounce in a frame; their outlines fire in proportion to the motion across the edge.
struct Scene {
  int width = 346;
  int height = 260;
  int objects = 20;
  double speed = 600;       // px/s, of the fastest
  double noise_hz = 0;      // per pixel
  double edge_density = 3;  // events per pixel of edge and pixel of motion across it
  std::uint64_t seed = 1;
};

inline std::vector<Event> make_scene(const Scene& scene, std::size_t count) {
  struct Disc {
    double x, y, vx, vy, r, rate;
  };
  const CounterRandom random(scene.seed);
  std::uint64_t draws = 0;
  const auto uniform = [&] { return random.uniform(draws++); };

  std::vector<Disc> discs;
  double rate = scene.noise_hz * scene.width * scene.height;  // events per second
  for (int i = 0; i < scene.objects; ++i) {
    const double r = 6 + 5 * uniform();
    const double v = scene.speed * (0.4 + 0.6 * uniform());
    const double angle = 2 * std::numbers::pi * uniform();
    discs.push_back({.x = r + (scene.width - 2 * r) * uniform(),
                     .y = r + (scene.height - 2 * r) * uniform(),
                     .vx = v * std::cos(angle),
                     .vy = v * std::sin(angle),
                     .r = r,
                     .rate = 4 * r * v * scene.edge_density});  // integral of |v . normal|
    rate += discs.back().rate;
  }

  const auto bounce = [](double& position, double& velocity, double r, double size) {
    if ((position < r && velocity < 0) || (position > size - r && velocity > 0))
      velocity = -velocity;
  };
  std::vector<Event> events;
  double t = 0;  // s
  while (events.size() < count) {
    const double step = -std::log(1 - uniform()) / rate;
    t += step;
    for (Disc& disc : discs) {
      disc.x += disc.vx * step;
      disc.y += disc.vy * step;
      bounce(disc.x, disc.vx, disc.r, scene.width);
      bounce(disc.y, disc.vy, disc.r, scene.height);
    }
    double choice = uniform() * rate;
    double x = uniform() * scene.width;
    double y = uniform() * scene.height;
    bool on = uniform() < 0.5;
    for (const Disc& disc : discs) {
      if (choice >= 0 && choice < disc.rate) {
        // |cos| has the integral sin: angle from the direction of motion by inversion.
        const double side = std::asin(2 * uniform() - 1);
        const double angle = std::atan2(disc.vy, disc.vx) + side + (on ? 0 : std::numbers::pi);
        x = disc.x + disc.r * std::cos(angle) + uniform() - 0.5;
        y = disc.y + disc.r * std::sin(angle) + uniform() - 0.5;
      }
      choice -= disc.rate;
    }
    if (x < 0 || y < 0 || x >= scene.width || y >= scene.height) continue;
    events.push_back({.x = static_cast<std::uint16_t>(x),
                      .y = static_cast<std::uint16_t>(y),
                      .p = static_cast<std::int16_t>(on),
                      .t = static_cast<std::int64_t>(t * 1e6)});
  }
  return events;
}

// A bar that crosses the frame and turns; its four edges fire in proportion to the motion across
// them.
struct Bar {
  double length = 36;
  double width = 6;
  double speed = 120;  // px/s, to the right
  double angle = 0.8;  // of the long edges, rad
  double turn = 0;     // rad/s
  double edge_density = 3;
  double noise_hz = 0.5;  // per pixel
  std::uint64_t seed = 1;
};

inline std::vector<Event> make_bar(const Bar& bar, double duration_s) {
  constexpr double kStep = 250e-6;
  constexpr double kWidth = 346;
  constexpr double kHeight = 260;
  const CounterRandom random(bar.seed);
  std::uint64_t draws = 0;
  const auto uniform = [&] { return random.uniform(draws++); };
  std::vector<Event> events;
  const auto add = [&](double x, double y, double t) {
    if (x < 0 || y < 0 || x >= kWidth || y >= kHeight) return;
    events.push_back({.x = static_cast<std::uint16_t>(x),
                      .y = static_cast<std::uint16_t>(y),
                      .p = static_cast<std::int16_t>(uniform() < 0.5),
                      .t = static_cast<std::int64_t>(t * 1e6)});
  };
  double due = 0;  // events
  double noise = 0;
  for (double t = 0; t < duration_s; t += kStep) {
    const double angle = bar.angle + bar.turn * t;
    for (int edge = 0; edge < 4; ++edge) {
      const double along = angle + edge * std::numbers::pi / 2;
      const double long_px = edge % 2 == 0 ? bar.length : bar.width;
      const double across_px = edge % 2 == 0 ? bar.width : bar.length;
      const double place = (uniform() - 0.5) * long_px;  // of one point of the edge
      const double across = bar.speed * std::sin(along) + bar.turn * place;
      for (due += bar.edge_density * long_px * std::abs(across) * kStep; due >= 1; --due) {
        const double x =
            60 + bar.speed * t + place * std::cos(along) - across_px / 2 * std::sin(along);
        const double y = 130 + place * std::sin(along) + across_px / 2 * std::cos(along);
        add(x + uniform() - 0.5, y + uniform() - 0.5, t);
      }
    }
    for (noise += bar.noise_hz * kWidth * kHeight * kStep; noise >= 1; --noise) {
      add(kWidth * uniform(), kHeight * uniform(), t);
    }
  }
  return events;
}

}  // namespace asap::test
