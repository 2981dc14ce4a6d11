// Events of a sensor of 640 x 480 px, in time order: many on one stamp or one row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/event.hpp"
#include "core/random.hpp"

namespace asap::test {

inline std::vector<Event> some_events(std::size_t count, std::int64_t first_us = 1'000'000) {
  const CounterRandom random(7);
  std::vector<Event> events;
  std::int64_t t = first_us;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random(i);
    if (bits % 3 == 0) t += static_cast<std::int64_t>((bits >> 8) % 30);
    events.push_back({.x = static_cast<std::uint16_t>((bits >> 20) % 640),
                      .y = static_cast<std::uint16_t>((bits >> 40) % 48 * 10),
                      .p = static_cast<std::int16_t>(bits >> 63),
                      .t = t});
  }
  return events;
}

}  // namespace asap::test
