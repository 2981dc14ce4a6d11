#include "algorithms/sensor_frame.hpp"

#include "asap/core/check.hpp"

namespace asap {
namespace {

std::uint32_t checked_side(const char* field, int value) {
  constexpr int kMaxSide = 16384;  // two polarities of such a frame still have int32 numbers
  require(1 <= value && value <= kMaxSide, field, value, "must be 1 to 16384 px");
  return static_cast<std::uint32_t>(value);
}

}  // namespace

SensorFrame::SensorFrame(int width, int height)
    : width_(checked_side("width", width)), height_(checked_side("height", height)) {}

}  // namespace asap
