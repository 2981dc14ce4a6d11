// StallWatch: whether the consumer of a live run still comes back. It says when it works, sleeps
// and looks up; any thread may ask. Stalled: awake, or never seen, for longer than kFactor times
// what a package is expected to take, the latency bound at least. That ends by itself when the
// consumer comes back. Times are those of the steady clock, ns.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/atomics.hpp"

namespace asap::inline v0_1 {

class StallWatch {
 public:
  static constexpr std::int64_t kFactor = 4;

  // Before the consumer has come: from now on there is something to do.
  void on_begin(std::int64_t now_ns) noexcept { since_ns_ = now_ns; }

  // Consumer.
  void on_work() noexcept { works_ = true; }
  void on_wake(std::int64_t now_ns, std::int64_t bound_ns) noexcept {
    if (works_) learn(now_ns - since_ns_, bound_ns);
    works_ = false;
    sleeps_ = false;
    since_ns_ = now_ns;
  }
  void on_sleep() noexcept { sleeps_ = true; }

  // Any thread, of a run in which something waits or is in work.
  bool stalled(std::int64_t now_ns, std::int64_t bound_ns) const noexcept {
    return !sleeps_ && now_ns - since_ns_ > kFactor * std::max(expected_ns_.load(), bound_ns);
  }

 private:
  // A stall does not become what is expected.
  void learn(std::int64_t processing_ns, std::int64_t bound_ns) noexcept {
    const std::int64_t max_ns = kFactor * std::max(expected_ns_.load(), bound_ns);
    expected_ns_ += (std::min(processing_ns, max_ns) - expected_ns_) / 8;
  }

  Relaxed<std::int64_t> since_ns_;
  Relaxed<std::int64_t> expected_ns_;  // smoothed processing time
  Relaxed<bool> sleeps_;
  bool works_ = false;  // the consumer's own
};

}  // namespace asap::inline v0_1
