// RecentTimes: one time per cell, in four bytes, for rules that ask only whether it is younger than
// a window of at most kMaxWindow_us. Times count from an origin that moves up when they would
// overflow, about every 18 minutes; what is then older than any window becomes `never`, which
// changes no answer. One thread. O(1) but for that move, which is one pass over the cells;
// allocates in the constructor only. Stamps that go back count as EventClock says.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/event_clock.hpp"

namespace asap::inline v0_1 {

class RecentTimes {
 public:
  using Time = std::int32_t;
  static constexpr std::int64_t kMaxWindow_us = 500'000'000;
  static constexpr Time kLongAgo = -(1 << 30);  // outside of every window

  // `never`: the time of a cell without an event. Either kLongAgo, or 0: time 0 is the timestamp 0,
  // or the microsecond before the first timestamp if that is not positive.
  RecentTimes(std::size_t cells, Time never) : never_(never), times_(cells, never) {}

  // The time of a stamp. Times read earlier are void when the origin has moved; the cells are not.
  Time time_of(std::int64_t stamp_us) noexcept {
    if (!clock_.started()) [[unlikely]]
      origin_us_ = EventClock::kOrigin_us - static_cast<std::uint64_t>(std::max(stamp_us, kFirst));
    clock_.advance(stamp_us);
    const std::uint64_t since_origin = clock_.now_us() - origin_us_;
    if (since_origin > kMaxTime) [[unlikely]]
      return move_origin(since_origin);
    return static_cast<Time>(since_origin);
  }

  // The time of the latest timestamp; it never goes back.
  std::int64_t now_us() const noexcept { return static_cast<std::int64_t>(clock_.now_us()); }

  Time* data() noexcept { return times_.data(); }

  void clear() noexcept;

 private:
  static constexpr std::uint64_t kMaxTime = std::numeric_limits<Time>::max();
  static constexpr std::int64_t kFirst = 1;  // the least time of an event

  Time move_origin(std::uint64_t since_origin) noexcept;

  Time never_;
  EventClock clock_;
  std::uint64_t origin_us_ = 0;  // of the clock
  std::vector<Time> times_;
};

inline void RecentTimes::clear() noexcept {
  std::fill(times_.begin(), times_.end(), never_);
  clock_ = {};
}

inline RecentTimes::Time RecentTimes::move_origin(std::uint64_t since_origin) noexcept {
  constexpr std::uint64_t kNow = std::uint64_t{1} << 30;
  const std::uint64_t shift = since_origin - kNow;
  origin_us_ += shift;
  const auto step = static_cast<std::int64_t>(std::min(shift, 2 * kMaxTime));
  for (Time& time : times_) {
    time = static_cast<Time>(std::max<std::int64_t>(time - step, never_));
  }
  return static_cast<Time>(kNow);
}

}  // namespace asap::inline v0_1
