// Time inside a run: nanoseconds, int64, on the run's own axis. TimeAxis ties it to timestamps,
// which are divided by `speed`. Zero is the whole second before the first one, so that at speed 1
// multiples of a period that divides a second are the same on both. Any thread, no allocation.
//   const double us = TimeAxis{first_us, 2.0}.to_us(run_ns);  // of a run at twice the speed
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>

namespace asap::inline v0_1 {

// The latency bound where the user gives none.
inline constexpr std::chrono::nanoseconds kDefaultLatency = std::chrono::milliseconds(10);

inline constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
inline constexpr std::int64_t kLongAgo = std::numeric_limits<std::int64_t>::min();

// Rounds down on both sides of zero. divisor > 0.
constexpr std::int64_t floor_div(std::int64_t value, std::int64_t divisor) noexcept {
  return value / divisor - (value % divisor < 0 ? 1 : 0);
}

class TimeAxis {
 public:
  TimeAxis() = default;
  TimeAxis(std::int64_t first_stamp_us, double speed) noexcept
      : zero_us_(floor_div(first_stamp_us, kSecond_us) * kSecond_us), ns_per_us_(1000.0 / speed) {}

  // Run time of a timestamp; saturates at about 290 years.
  std::int64_t to_ns(std::int64_t stamp_us) const noexcept {
    const double ns = static_cast<double>(stamp_us - zero_us_) * ns_per_us_;
    return static_cast<std::int64_t>(std::clamp(ns, -kLimit, kLimit));
  }

  // A run time on the recording's own axis. Exact to 0.25 us for Unix times.
  double to_us(std::int64_t run_ns) const noexcept {
    return static_cast<double>(zero_us_) + static_cast<double>(run_ns) / ns_per_us_;
  }

 private:
  static constexpr double kLimit = 9.2e18;
  static constexpr std::int64_t kSecond_us = 1'000'000;

  std::int64_t zero_us_ = 0;
  double ns_per_us_ = 1000.0;
};

}  // namespace asap::inline v0_1
