// Streams of events whose pixels say which event it is: number i lies in x and y, so that a test
// sees at once what is missing, doubled or out of order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/event.hpp"
#include "core/random.hpp"

namespace asap::test {

using Events = std::vector<Event>;

constexpr Event numbered(std::uint64_t number, std::int64_t t_us) noexcept {
  return {static_cast<std::uint16_t>(number), static_cast<std::uint16_t>(number >> 16),
          static_cast<std::int16_t>(number & 1), t_us};
}

constexpr std::uint64_t number_of(const Event& event) noexcept {
  return event.x + (std::uint64_t{event.y} << 16);
}

inline std::vector<std::uint64_t> numbers_of(EventSpan events) {
  std::vector<std::uint64_t> numbers;
  for (const Event& event : events) numbers.push_back(number_of(event));
  return numbers;
}

inline Events evenly_spaced(std::size_t count, std::int64_t step_us, std::int64_t first_us = 0) {
  Events events;
  for (std::size_t i = 0; i < count; ++i) {
    events.push_back(numbered(i, first_us + static_cast<std::int64_t>(i) * step_us));
  }
  return events;
}

inline Events at_times(const std::vector<std::int64_t>& stamps_us) {
  Events events;
  for (const std::int64_t stamp : stamps_us) events.push_back(numbered(events.size(), stamp));
  return events;
}

// Random gaps in random regimes: bursts on one stamp, 1 Mev/s, 50 kev/s, silences of 30 ms.
inline Events random_stream(std::uint64_t seed, std::size_t count, std::int64_t first_us = 0) {
  const CounterRandom random(seed);
  Events events;
  std::int64_t t = first_us;
  std::uint64_t regime = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random(i);
    if (bits % 64 == 0) regime = (bits >> 8) % 4;
    const auto spread = static_cast<std::int64_t>((bits >> 16) % 1000);
    if (regime == 1) t += spread % 3;
    if (regime == 2) t += spread % 41;
    if (regime == 3 && bits % 16 == 0) t += 30 * spread;
    events.push_back(numbered(i, t));
  }
  return events;
}

}  // namespace asap::test
