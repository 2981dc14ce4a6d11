// The checks that every synthetic scene's configuration shares.
#pragma once

#include <cstdint>

#include "core/check.hpp"

namespace asap::inline v0_1::synthetic {

inline void require_view_and_time(std::int32_t width, std::int32_t height, std::int64_t duration_us,
                                  std::int64_t t0_us) {
  constexpr std::int64_t kLastTime_us = std::int64_t{1} << 62;
  require(width >= 16 && width <= 8192, "width", width, "give the sensor's width, 16 to 8192 px");
  require(height >= 16 && height <= 8192, "height", height,
          "give the sensor's height, 16 to 8192 px");
  require(duration_us >= 10'000 && duration_us <= 86'400'000'000, "duration_us", duration_us,
          "give 10 ms to one day, in us");
  require(t0_us >= -kLastTime_us && t0_us <= kLastTime_us, "t0_us", t0_us,
          "give a time within 2^62 us of zero");
}

}  // namespace asap::inline v0_1::synthetic
