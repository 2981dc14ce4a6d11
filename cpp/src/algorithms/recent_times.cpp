#include "algorithms/recent_times.hpp"

namespace asap {

void RecentTimes::clear() noexcept {
  std::fill(times_.begin(), times_.end(), never_);
  started_ = false;
  last_us_ = std::numeric_limits<std::int64_t>::min();
}

RecentTimes::Time RecentTimes::move_origin() noexcept {
  constexpr std::uint64_t kNow = std::uint64_t{1} << 30;
  if (!started_) {
    started_ = true;
    const bool lowest = last_us_ == std::numeric_limits<std::int64_t>::min();
    origin_us_ = std::min<std::int64_t>(0, lowest ? last_us_ : last_us_ - 1);
  }
  const std::uint64_t since_origin = distance(origin_us_, last_us_);
  if (since_origin <= kMaxTime) return static_cast<Time>(since_origin);

  const std::uint64_t shift = since_origin - kNow;
  origin_us_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(origin_us_) + shift);
  const auto step = static_cast<std::int64_t>(std::min(shift, 2 * kMaxTime));
  for (Time& time : times_) {
    time = static_cast<Time>(std::max<std::int64_t>(time - step, never_));
  }
  return static_cast<Time>(kNow);
}

}  // namespace asap
