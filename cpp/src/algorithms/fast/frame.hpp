// Frame: the sensor's size, and whether a track has left it. Pure, O(1).
#pragma once

#include <cstdint>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

struct Frame {
  std::uint32_t width;  // px
  std::uint32_t height;
};

// Its mean lies more than 2 px beyond the last pixels' edges, or is no number.
inline bool has_left(const Track& track, Stamp now, const Frame& frame) noexcept {
  const Sight s = sight_of(track, now, 0, 0);
  const auto right = static_cast<float>(frame.width + 2);
  const auto bottom = static_cast<float>(frame.height + 2);
  return !(s.mean_x >= -3 && s.mean_x <= right && s.mean_y >= -3 && s.mean_y <= bottom);
}

}  // namespace asap::fast
