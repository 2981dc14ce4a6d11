// OrphanNoise: the noise rate as the first design measures it: a low pass over the rate of the
// unassociated events, and the count from which they are more than noise. One thread.
// O(1), no allocation.
// Source: own design.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace asap {

class OrphanNoise {
 public:
  void count() noexcept { ++orphans_; }

  // At the tick: elapsed_s since the last one; area_px2 where no cluster is. `warming`: nothing may
  // be born yet. Births look at around_px2 for memory_s.
  void update(float elapsed_s, float area_px2, bool warming, float around_px2,
              float memory_s) noexcept {
    const float raw_hz = static_cast<float>(orphans_) / (area_px2 * elapsed_s);
    rate_hz_ += (warming ? 0.2F : 0.03F) * (raw_hz - rate_hz_);
    orphans_ = 0;
    if (warming) return;
    const float expected = rate_hz_ * around_px2 * memory_s;
    threshold_ = std::max(kLeast, expected + 4 * std::sqrt(expected) + 2);
  }

  // Per pixel.
  float rate_hz() const noexcept { return rate_hz_; }

  // Events; infinite until it is warm.
  float threshold() const noexcept { return threshold_; }

 private:
  static constexpr float kLeast = 6;  // events

  std::uint64_t orphans_ = 0;                                 // since the last tick
  float rate_hz_ = 0;                                         // per pixel
  float threshold_ = std::numeric_limits<float>::infinity();  // events
};

}  // namespace asap
