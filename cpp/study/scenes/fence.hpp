// Fence: wires at rest before a scene, which hide what moves behind them. Any thread but for the
// constructor, which fixes the memory; O(1) per pixel; + - * / only (see event_stream.hpp).
#pragma once

#include <cstdint>
#include <vector>

#include "synthetic/plane.hpp"

namespace asap {

struct FenceConfig {
  std::vector<UnitVector> across{};  // of each set of parallel wires
  double pitch_px = 16.0;            // from a wire to the next
  double wire_px = 3.0;
  double brightness = 0.2;  // 0.02 to 1
};

class Fence {
 public:
  Fence(const FenceConfig& config, std::int32_t width, std::int32_t height);

  // What a pixel (x + width y) sees of this brightness behind the wires.
  double before(std::uint32_t pixel, double brightness) const noexcept {
    return brightness + hidden_[pixel] * (brightness_ - brightness);
  }

 private:
  double brightness_;
  std::vector<double> hidden_;  // share of each pixel
};

}  // namespace asap
