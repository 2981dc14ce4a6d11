// SensorFrame: the pixels of a sensor, as the filters and corner detectors know it: which events
// lie outside, and which lie too close to the border for a neighbourhood. Checked once, O(1).
#pragma once

#include <cstdint>

#include "asap/core/event.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

class SensorFrame {
 public:
  // Throws std::invalid_argument that names the bad field.
  SensorFrame(int width, int height)
      : width_(checked_side("width", width)), height_(checked_side("height", height)) {}

  bool contains(const Event& event) const noexcept { return event.x < width_ && event.y < height_; }

  // Whether `margin` pixels lie between the event and every border.
  bool contains(const Event& event, std::uint32_t margin) const noexcept {
    return event.x >= margin && event.x + margin < width_ && event.y >= margin &&
           event.y + margin < height_;
  }

  std::uint32_t width() const noexcept { return width_; }
  std::uint32_t height() const noexcept { return height_; }

 private:
  static std::uint32_t checked_side(const char* field, int value) {
    constexpr int kMaxSide = 16384;  // two polarities of such a frame still have int32 numbers
    require(1 <= value && value <= kMaxSide, field, value, "must be 1 to 16384 px");
    return static_cast<std::uint32_t>(value);
  }

  std::uint32_t width_;
  std::uint32_t height_;
};

}  // namespace asap::inline v0_1
