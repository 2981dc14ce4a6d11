// What every synthetic scene has to hold, shared by the scenes' tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "asap/synthetic/streams.hpp"
#include "core/random.hpp"

namespace asap::test {

template <class Stream, class Config>
std::vector<Event> all_events(const Config& config) {
  Stream stream{config};
  return read_events(stream, SIZE_MAX);
}

// Over fields and positions; test_synthetic.py computes the same with NumPy.
inline std::uint64_t fingerprint(EventSpan events) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& event = events[i];
    const std::uint64_t place = event.x | static_cast<std::uint64_t>(event.y) << 16 |
                                static_cast<std::uint64_t>(event.p) << 32;
    sum += detail::mix(detail::mix(place ^ static_cast<std::uint64_t>(event.t) << 33) + i);
  }
  return sum;
}

// Events per second in each window of [t0, t0 + duration).
inline std::vector<double> rates_hz(EventSpan events, std::int64_t t0_us, std::int64_t duration_us,
                                    std::int64_t window_us) {
  std::vector<double> rates(static_cast<std::size_t>(duration_us / window_us));
  for (const Event& event : events) {
    rates.at(static_cast<std::size_t>((event.t - t0_us) / window_us)) +=
        1e6 / static_cast<double>(window_us);
  }
  return rates;
}

template <class Config>
void expect_well_formed(EventSpan events, const Config& config) {
  ASSERT_FALSE(events.empty());
  EXPECT_TRUE(std::ranges::is_sorted(events, {}, &Event::t));
  if constexpr (requires { config.start; }) {
    EXPECT_GE(events.front().t, config.start.count());
    EXPECT_LT(events.back().t, (config.start + config.duration).count());
  } else {  // a scene of the study
    EXPECT_GE(events.front().t, config.t0_us);
    EXPECT_LT(events.back().t, config.t0_us + config.duration_us);
  }
  EXPECT_TRUE(std::ranges::all_of(events, [&](const Event& event) {
    return event.x < config.width && event.y < config.height && (event.p == 0 || event.p == 1);
  }));
}

}  // namespace asap::test
