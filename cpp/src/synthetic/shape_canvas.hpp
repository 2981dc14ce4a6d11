// ShapeCanvas: the picture of moving shapes on an even ground, kept up to date around them only:
// begin(), paint() every shape in the same order, then read the pixels that may have changed. What
// is painted later lies on top; the last object that covered a pixel owns it, also after it left.
// Any one thread; O(pixels near a shape) per paint(), memory fixed by the constructor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "synthetic/rigid_motion.hpp"
#include "synthetic/rigid_shape.hpp"

namespace asap {

class ShapeCanvas {
 public:
  static constexpr std::int32_t kNobody = -1;

  ShapeCanvas(std::int32_t width, std::int32_t height, double ground);

  void begin() noexcept;

  // Between two pictures a shape may move by 1 px at most.
  void paint(const RigidShape& shape, const Pose& pose, double brightness,
             std::int32_t object) noexcept;

  // Pixels (x + width y) near the shapes of this picture; the others show the ground.
  std::span<const std::uint32_t> touched() const noexcept { return {touched_.data(), size_}; }

  double brightness(std::uint32_t pixel) const noexcept { return brightness_[pixel]; }
  std::int32_t owner(std::uint32_t pixel) const noexcept { return owners_[pixel]; }

 private:
  std::int32_t width_;
  std::int32_t height_;
  double ground_;
  std::uint64_t picture_ = 0;
  std::vector<std::uint64_t> pictures_;  // in which the pixel was touched last
  std::vector<double> brightness_;
  std::vector<std::int32_t> owners_;
  std::vector<std::uint32_t> touched_;
  std::size_t size_ = 0;
};

}  // namespace asap
