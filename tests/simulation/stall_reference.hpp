// StallReference: when a consumer is stalled, from the words of runner/stall_watch.hpp. It is seen
// from outside, so the time of its last look may be known to a span only.
#pragma once

#include <algorithm>
#include <cstdint>

namespace asap::simulation {

class StallReference {
 public:
  void looks_up(std::int64_t now_ns, bool has_worked, std::int64_t bound_ns) noexcept {
    if (has_worked) {
      min_ns_ = learned(min_ns_, now_ns - last_ns_, bound_ns);
      max_ns_ = learned(max_ns_, now_ns - first_ns_, bound_ns);
    }
    first_ns_ = last_ns_ = now_ns;
  }
  // It may have looked up once more.
  void may_look_up(std::int64_t now_ns) noexcept { last_ns_ = now_ns; }

  bool must_be_stalled(std::int64_t now_ns, std::int64_t bound_ns) const noexcept {
    return now_ns - last_ns_ > 4 * std::max(max_ns_, bound_ns);
  }
  bool may_be_stalled(std::int64_t now_ns, std::int64_t bound_ns) const noexcept {
    return now_ns - first_ns_ > 4 * std::max(min_ns_, bound_ns);
  }

 private:
  static std::int64_t learned(std::int64_t expected_ns, std::int64_t processing_ns,
                              std::int64_t bound_ns) noexcept {
    const std::int64_t limit_ns = 4 * std::max(expected_ns, bound_ns);
    return expected_ns + (std::min(processing_ns, limit_ns) - expected_ns) / 8;
  }

  std::int64_t first_ns_ = 0;  // the last look is not before this ...
  std::int64_t last_ns_ = 0;   // ... and not behind this
  std::int64_t min_ns_ = 0;    // expected processing time
  std::int64_t max_ns_ = 0;
};

}  // namespace asap::simulation
