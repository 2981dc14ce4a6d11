// The gap of a run as a look at every event finds it: what a GapMeter must agree with.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "asap/core/event.hpp"

namespace asap::test {

// `delivered` is what is left of `received`, in order; events are told apart by their fields.
inline std::int64_t gap_us(EventSpan received, EventSpan delivered) {
  std::int64_t longest_us = 0;
  std::size_t next = 0;
  bool is_lost = false;
  for (std::int64_t kept_until_us = received.empty() ? 0 : received.front().t;
       const Event& event : received) {
    const bool is_kept = next < delivered.size() && event == delivered[next];
    if (is_lost || !is_kept) longest_us = std::max(longest_us, event.t - kept_until_us);
    if (is_kept) kept_until_us = event.t;
    is_lost = !is_kept;
    next += is_kept ? 1 : 0;
  }
  return longest_us;
}

}  // namespace asap::test
