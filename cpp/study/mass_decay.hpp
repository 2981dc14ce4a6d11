// mass_decay: exp(-u) as the rival trackers take it for every event: the first terms of its series
// where events follow each other quickly, which is nearly always. Relative error below .004 there.
// Pure, O(1).
// Source: first design of the fast engine.
#pragma once

#include "algorithms/fast/time.hpp"

namespace asap {

// u >= 0
constexpr float mass_decay(float u) noexcept {
  return u < 0.25F ? 1 - u + u * u / 2 : fast::decay(u);
}

}  // namespace asap
