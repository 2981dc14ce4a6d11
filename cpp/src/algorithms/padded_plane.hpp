// PaddedPlane: a value per pixel of the sensor, for rules that change the window around an event. A
// border of zeros as wide as half the window lies around the frame, so no rule asks where it ends,
// and rows of the window may be taken in blocks of kLanes values. One thread; O(1) but for copies
// and clear; allocates in the constructor only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/sensor_frame.hpp"
#include "asap/core/event.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

template <class Value>
class PaddedPlane {
 public:
  static constexpr std::size_t kLanes = 16 / sizeof(Value);

  PaddedPlane(const SensorFrame& frame, std::uint32_t reach)
      : width_(frame.width()),
        height_(frame.height()),
        reach_(reach),
        stride_(width_ + 2 * reach + kLanes),
        values_(stride_ * (height_ + 2 * reach)) {}

  Value* pixel(std::uint32_t x, std::uint32_t y) noexcept { return values_.data() + index(x, y); }
  Value at(std::uint32_t x, std::uint32_t y) const noexcept { return values_[index(x, y)]; }
  std::ptrdiff_t stride() const noexcept { return static_cast<std::ptrdiff_t>(stride_); }

  // The first value of each row of the window around an event; kLanes more may be touched.
  Value* corner(const Event& event) noexcept {
    return values_.data() + event.y * stride_ + event.x;
  }

  // Blocks of kLanes values that hold a row of the window.
  std::size_t blocks() const noexcept { return (2 * reach_ + kLanes) / kLanes; }

  // The frame, row by row. Throws std::invalid_argument if `out` has another size.
  void copy_to(std::span<Value> out) const {
    require(out.size() == width_ * height_, "out.size()", out.size(), "must be width x height");
    for (std::uint32_t y = 0; y < height_; ++y) {
      std::copy_n(values_.data() + index(0, y), width_, out.data() + y * width_);
    }
  }

  void clear() noexcept { std::fill(values_.begin(), values_.end(), Value{0}); }

 private:
  std::size_t index(std::uint32_t x, std::uint32_t y) const noexcept {
    return (y + reach_) * stride_ + x + reach_;
  }

  std::size_t width_;
  std::size_t height_;
  std::size_t reach_;
  std::size_t stride_;
  std::vector<Value> values_;
};

}  // namespace asap::inline v0_1
