// EventClock: the time of an algorithm, which never goes back. A timestamp that goes back by at
// most a second counts as the latest one. A larger step back begins a new epoch (the sensor was
// reset, its counter wrapped, or one timestamp was far ahead): time stands still for that event and
// goes on from there. Any int64 is a valid timestamp. One thread. O(1), no allocation.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace asap::inline v0_1 {

// later - earlier, without overflow.
constexpr std::uint64_t distance_us(std::int64_t earlier, std::int64_t later) noexcept {
  return static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier);
}

// Precondition: the timestamp is not after the latest one.
constexpr bool begins_epoch(std::int64_t latest_us, std::int64_t stamp_us) noexcept {
  constexpr std::uint64_t kBackStep_us = 1'000'000;
  return distance_us(stamp_us, latest_us) > kBackStep_us;
}

class EventClock {
 public:
  // The time of the first event: a second before 32 bits wrap, so that every run sees them wrap.
  static constexpr std::uint64_t kOrigin_us = (std::uint64_t{1} << 32) - 1'000'000;
  // A longer step counts as 11.6 days, so that no hostile stream overflows the time.
  static constexpr std::uint64_t kLongestStep_us = 1'000'000'000'000;

  // True: the timestamp begins a new epoch.
  bool advance(std::int64_t t_us) noexcept {
    if (started_ && t_us >= latest_us_) [[likely]] {
      const std::uint64_t step_us = distance_us(latest_us_, t_us);
      if (step_us > kLongestStep_us) origin_us_ -= step_us - kLongestStep_us;
      step_to(t_us);
      return false;
    }
    if (started_ && !begins_epoch(latest_us_, t_us)) return false;
    const bool new_epoch = started_;
    started_ = true;
    origin_us_ = now_us() - static_cast<std::uint64_t>(t_us);
    latest_us_ = t_us;
    return new_epoch;
  }

  // Precondition: the clock has started, and the timestamp is the latest one or a short step later.
  void step_to(std::int64_t t_us) noexcept { latest_us_ = t_us; }

  // Advances without an event. A time of the past is ignored.
  void advance_to(std::int64_t t_us) noexcept {
    if (t_us > latest_us_) advance(t_us);
  }

  // us; only differences have a meaning.
  std::uint64_t now_us() const noexcept {
    return origin_us_ + static_cast<std::uint64_t>(latest_us_);
  }
  std::uint32_t now() const noexcept { return static_cast<std::uint32_t>(now_us()); }
  bool started() const noexcept { return started_; }

  // The latest stamp.
  std::int64_t latest_us() const noexcept { return latest_us_; }
  // The timestamp of what is age_us old, negative for the future; clamped to int64.
  std::int64_t stamp_us(std::int64_t age_us) const noexcept {
    using Stamps = std::numeric_limits<std::int64_t>;
    if (age_us < 0) return std::min(latest_us_, Stamps::max() + age_us) - age_us;
    return std::max(latest_us_, Stamps::min() + age_us) - age_us;
  }

 private:
  bool started_ = false;
  std::int64_t latest_us_ = 0;
  std::uint64_t origin_us_ = kOrigin_us;  // the time of timestamp 0
};

}  // namespace asap::inline v0_1
