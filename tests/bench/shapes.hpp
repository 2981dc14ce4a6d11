// Streams of turning shapes for the benchmarks of corners, surfaces and filters.
#pragma once

#include <cstddef>
#include <vector>

#include "algorithms/corner_streams.hpp"

namespace asap::bench {

constexpr std::size_t kEvents = 200'000;

using Events = std::vector<Event>;
using Stream = const Events& (*)();

// ArcStar tests 82 % of these events, a quarter of the others.
inline const Events& golden() {
  static const auto events = test::golden_corner_stream(kEvents);
  return events;
}

inline const Events& fast() {
  static const auto events = test::turning_shapes({.speed = 700}, kEvents);
  return events;
}

inline const Events& noisy() {
  static const auto events = test::turning_shapes({.speed = 300, .noise_hz = 8}, kEvents);
  return events;
}

}  // namespace asap::bench
