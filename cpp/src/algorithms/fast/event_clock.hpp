// EventClock: the time of the fast engine, which never goes back. A stamp that goes back by less
// than a second counts as the latest one; by more, it begins a new epoch (a sensor was reset, its
// counter wrapped): time stands still for that event and goes on from there. Any int64 is a stamp.
// One thread. O(1), no allocation.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "algorithms/fast/stamp.hpp"

namespace asap::fast {

class EventClock {
 public:
  static constexpr std::uint64_t kBackStep_us = 1'000'000;
  // The time of the first event: a second before Stamp wraps, so that every run sees it wrap.
  static constexpr std::uint64_t kOrigin_us = (std::uint64_t{1} << 32) - 1'000'000;

  void advance(std::int64_t t_us) noexcept {
    if (t_us >= latest_us_) [[likely]] {
      if (started_) now_us_ += distance(latest_us_, t_us);
    } else if (started_ && distance(t_us, latest_us_) <= kBackStep_us) {
      return;
    }
    started_ = true;
    latest_us_ = t_us;
  }

  // Without an event: a time that goes back means nothing.
  void advance_to(std::int64_t t_us) noexcept {
    if (t_us > latest_us_) advance(t_us);
  }

  // us, of no meaning but its differences.
  std::uint64_t now_us() const noexcept { return now_us_; }
  Stamp now() const noexcept { return static_cast<Stamp>(now_us_); }
  bool started() const noexcept { return started_; }

  // The latest stamp.
  std::int64_t latest_us() const noexcept { return latest_us_; }
  // The stamp of what is that old, or still to come; the first or the last one if that is beyond.
  std::int64_t stamp_us(std::int32_t age_us) const noexcept {
    using Stamps = std::numeric_limits<std::int64_t>;
    if (age_us < 0) return std::min(latest_us_, Stamps::max() + age_us) - age_us;
    return std::max(latest_us_, Stamps::min() + age_us) - age_us;
  }

 private:
  static std::uint64_t distance(std::int64_t earlier, std::int64_t later) noexcept {
    return static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier);
  }

  bool started_ = false;
  std::int64_t latest_us_ = 0;
  std::uint64_t now_us_ = kOrigin_us;
};

}  // namespace asap::fast
