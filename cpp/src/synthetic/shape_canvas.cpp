#include "synthetic/shape_canvas.hpp"

#include <algorithm>
#include <cmath>

namespace asap {
namespace {

double square(double value) noexcept { return value * value; }

}  // namespace

ShapeCanvas::ShapeCanvas(std::int32_t width, std::int32_t height, double ground)
    : width_(width), height_(height), ground_(ground) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  pictures_.resize(pixels);
  brightness_.resize(pixels, ground);
  owners_.resize(pixels, kNobody);
  touched_.resize(pixels);
}

void ShapeCanvas::begin() noexcept {
  ++picture_;
  size_ = 0;
}

void ShapeCanvas::paint(const RigidShape& shape, const Pose& pose, double brightness,
                        std::int32_t object) noexcept {
  // Half a pixel beyond the outline, and where the shape was in the picture before.
  const double near_px = shape.reach_px() + 0.5 + 1.0;
  const double near_square = near_px * near_px;
  const double outside = square(shape.reach_px() + 0.5);
  const double inside = square(std::max(shape.inner_px() - 0.5, 0.0));
  const auto first = [&](double centre) {
    return std::max(static_cast<std::int32_t>(std::ceil(centre - near_px)), 0);
  };
  const auto end = [&](double centre, std::int32_t size) {
    return std::min(static_cast<std::int32_t>(std::floor(centre + near_px)) + 1, size);
  };
  const std::int32_t first_x = first(pose.position.x);
  const std::int32_t end_x = end(pose.position.x, width_);
  const std::int32_t end_y = end(pose.position.y, height_);
  for (std::int32_t y = first(pose.position.y); y < end_y; ++y) {
    const double dy = y - pose.position.y;
    for (std::int32_t x = first_x; x < end_x; ++x) {
      const double dx = x - pose.position.x;
      const double from_centre = dx * dx + dy * dy;
      if (from_centre > near_square) continue;
      const auto pixel = static_cast<std::uint32_t>(x + width_ * y);
      if (pictures_[pixel] != picture_) {
        pictures_[pixel] = picture_;
        brightness_[pixel] = ground_;
        touched_[size_++] = pixel;
      }
      if (from_centre >= outside) continue;
      if (from_centre < inside) {
        brightness_[pixel] = brightness;
        owners_[pixel] = object;
        continue;
      }
      const double covered = shape.coverage(
          {dx * pose.axis.x + dy * pose.axis.y, dy * pose.axis.x - dx * pose.axis.y});
      if (covered == 0.0) continue;
      brightness_[pixel] = brightness_[pixel] * (1.0 - covered) + brightness * covered;
      owners_[pixel] = object;
    }
  }
}

}  // namespace asap
