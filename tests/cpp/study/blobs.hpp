// Small objects for the tests of the rival trackers: squares of pixels that move as told.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "asap/core/event.hpp"
#include "core/random.hpp"

namespace asap::test {

struct Place {
  double x;
  double y;
};

inline Event event_at(int x, int y, std::int64_t t_us) {
  return {
      .x = static_cast<std::uint16_t>(x), .y = static_cast<std::uint16_t>(y), .p = 1, .t = t_us};
}

inline std::vector<Event> repeated(int x, int y, std::int64_t t_us, int count) {
  return std::vector<Event>(static_cast<std::size_t>(count), event_at(x, y, t_us));
}

// Twenty events per millisecond and blob, evenly in squares of 11 px around where it is then.
using Path = std::function<Place(double t_s)>;

inline std::vector<Event> blobs(std::int64_t begin_us, std::int64_t end_us,
                                const std::vector<Path>& paths) {
  const CounterRandom random(5);
  std::uint64_t draws = 0;
  const auto offset = [&] { return 11 * random.uniform(draws++) - 5.5; };
  std::vector<Event> events;
  for (std::int64_t t_us = begin_us; t_us < end_us; t_us += 50) {
    for (const Path& path : paths) {
      const Place at = path(1e-6 * static_cast<double>(t_us));
      events.push_back(event_at(static_cast<int>(std::lround(at.x + offset())),
                                static_cast<int>(std::lround(at.y + offset())), t_us));
    }
  }
  return events;
}

inline Path resting(double x, double y) {
  return [=](double) { return Place{x, y}; };
}

inline Path moving(double x, double y, double vx, double vy) {
  return [=](double t_s) { return Place{x + vx * t_s, y + vy * t_s}; };
}

}  // namespace asap::test
