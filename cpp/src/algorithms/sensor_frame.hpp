// SensorFrame: the pixels of a sensor, as the filters and corner detectors know it: which events
// lie outside, and which lie too close to the border for a neighbourhood. Checked once, O(1).
#pragma once

#include <cstdint>

#include "asap/core/event.hpp"

namespace asap {

class SensorFrame {
 public:
  // Throws std::invalid_argument that names the bad field.
  SensorFrame(int width, int height);

  bool contains(const Event& event) const noexcept { return event.x < width_ && event.y < height_; }

  // Whether `margin` pixels lie between the event and every border.
  bool contains(const Event& event, std::uint32_t margin) const noexcept {
    return event.x >= margin && event.x + margin < width_ && event.y >= margin &&
           event.y + margin < height_;
  }

  std::uint32_t width() const noexcept { return width_; }
  std::uint32_t height() const noexcept { return height_; }

 private:
  std::uint32_t width_;
  std::uint32_t height_;
};

}  // namespace asap
