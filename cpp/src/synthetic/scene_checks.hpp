// The checks that every synthetic scene's configuration shares.
#pragma once

#include <cstdint>

#include "asap/core/check.hpp"

namespace asap::synthetic {

template <class Config>
void require_view_and_time(const Config& config) {
  constexpr std::int64_t kLastTime_us = std::int64_t{1} << 62;
  require(config.width >= 16 && config.width <= 8192, "width", config.width,
          "give the sensor's width, 16 to 8192 px");
  require(config.height >= 16 && config.height <= 8192, "height", config.height,
          "give the sensor's height, 16 to 8192 px");
  require(config.duration_us >= 10'000 && config.duration_us <= 86'400'000'000, "duration_us",
          config.duration_us, "give 10 ms to one day, in us");
  require(config.t0_us >= -kLastTime_us && config.t0_us <= kLastTime_us, "t0_us", config.t0_us,
          "give a time within 2^62 us of zero");
}

}  // namespace asap::synthetic
