// SensorDelay: how much longer than at best events take from the sensor to the pipeline. The two
// clocks share no zero and run at different speeds, so the difference (arrival - timestamp) is
// compared with its own minimum over the last 5 to 10 seconds: a skew of 100 ppm is then worth less
// than a millisecond, and no step of a wall clock matters. Reported only; no decision depends on
// it. The producer's thread notes, any thread may read. Source: a running minimum, as clock filters
// use it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/atomics.hpp"

namespace asap::inline v0_1 {

class SensorDelay {
 public:
  static constexpr std::int64_t kWindowNs = 5'000'000'000;

  // The newest event of a push: its timestamp, and when it came on the host's steady clock.
  void note(std::int64_t stamp_us, std::int64_t arrival_ns) noexcept {
    const std::int64_t difference_ns = arrival_ns - stamp_us * 1000;
    const bool is_first = window_start_ns_ == kNone;
    if (is_first || arrival_ns - window_start_ns_ >= kWindowNs) {
      before_ns_ = is_first ? kNone : min_ns_;
      window_start_ns_ = arrival_ns;
      min_ns_ = difference_ns;
    }
    min_ns_ = std::min(min_ns_, difference_ns);
    last_ns_ = difference_ns - std::min(min_ns_, before_ns_);
    max_ns_ = std::max(max_ns_.load(), last_ns_.load());
  }

  // The sensor's clock has been set back: what was learnt about it is void.
  void forget() noexcept { window_start_ns_ = kNone; }

  // Beyond the least delay of late; of the last push, and the longest so far. Never negative.
  std::int64_t last_ns() const noexcept { return last_ns_; }
  std::int64_t max_ns() const noexcept { return max_ns_; }

 private:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  std::int64_t window_start_ns_ = kNone;
  std::int64_t min_ns_ = kNone;     // of this window
  std::int64_t before_ns_ = kNone;  // of the window before
  Relaxed<std::int64_t> last_ns_;
  Relaxed<std::int64_t> max_ns_;
};

}  // namespace asap::inline v0_1
