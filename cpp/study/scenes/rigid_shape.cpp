#include "study/scenes/rigid_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"
#include "synthetic/plane.hpp"

namespace asap {
namespace {

constexpr double kTan60 = 1.7320508075688772;
constexpr double kTan18 = 0.32491969623290633;

double length_px(PlanePoint point) noexcept {
  return std::sqrt(point.x * point.x + point.y * point.y);
}

}  // namespace

RigidShape::RigidShape(ShapeKind kind, double radius_px, double thickness_px)
    : reach_px_(radius_px), hole_px_(-radius_px), inner_px_(radius_px) {
  require(radius_px >= 1.0 && radius_px <= kMaxRadius_px, "radius_px", radius_px,
          "give 1 to 1000 px");
  const bool is_thick = kind >= ShapeKind::kBar;
  require(is_thick ? thickness_px >= 1.0 && thickness_px < radius_px : thickness_px == 0.0,
          "thickness_px", thickness_px,
          is_thick ? "give 1 px or more, and less than the radius"
                   : "only bars, angles and rings have one");
  switch (kind) {
    case ShapeKind::kDisk:
      return;
    case ShapeKind::kSquare:
      add_box(radius_px, radius_px);
      break;
    case ShapeKind::kRectangle:
      add_box(radius_px, 0.5 * radius_px);
      break;
    case ShapeKind::kTriangle:
      add_ring(3, kTan60, 1.2 * radius_px, 1.2 * radius_px);
      break;
    case ShapeKind::kStar:
      add_ring(10, kTan18, 1.3 * radius_px, 0.5 * radius_px);
      convex_ = false;
      break;
    case ShapeKind::kBar:
      add_box(radius_px, 0.5 * thickness_px);
      break;
    case ShapeKind::kAngle:
      add_angle(radius_px, thickness_px);
      convex_ = false;
      break;
    case ShapeKind::kRing:
      hole_px_ = radius_px - thickness_px;
      inner_px_ = -hole_px_;
      return;
  }
  join_vertices();
}

double RigidShape::distance_px(PlanePoint point) const noexcept {
  if (size_ == 0) {
    const double from_centre = length_px(point);
    return std::max(from_centre - reach_px_, hole_px_ - from_centre);
  }
  double nearest = reach_px_ * reach_px_ + point.x * point.x + point.y * point.y;
  nearest *= 2.0;  // no outline is farther
  bool inside = false;
  for (std::size_t i = 0; i < size_; ++i) {
    const PlanePoint along = edges_[i].along;
    const double x = point.x - vertices_[i].x;
    const double y = point.y - vertices_[i].y;
    const double part =
        std::clamp((x * along.x + y * along.y) * edges_[i].inverse_square, 0.0, 1.0);
    const double away_x = x - part * along.x;
    const double away_y = y - part * along.y;
    nearest = std::min(nearest, away_x * away_x + away_y * away_y);

    // A ray to the left of the point meets the outline an odd number of times from inside.
    const bool above = y < 0.0;
    const bool next_above = y < along.y;
    const bool right_of_edge = (x * along.y > y * along.x) == (along.y > 0.0);
    if (above != next_above && right_of_edge) inside = !inside;
  }
  return inside ? -std::sqrt(nearest) : std::sqrt(nearest);
}

double RigidShape::coverage(PlanePoint point, double scale) const noexcept {
  if (size_ > 0 && convex_) {
    // Inside this is the distance, outside a lower bound of it: cheap where it decides.
    const double beyond_px = scale * beyond_edges_px(point);
    if (beyond_px >= 0.5) return 0.0;
    if (beyond_px <= 0.0) return std::min(0.5 - beyond_px, 1.0);
  }
  return std::clamp(0.5 - scale * distance_px(point), 0.0, 1.0);
}

double RigidShape::beyond_edges_px(PlanePoint point) const noexcept {
  double beyond_px = -reach_px_;
  for (std::size_t i = 0; i < size_; ++i) {
    const PlanePoint outward = edges_[i].outward;
    beyond_px = std::max(
        beyond_px, (point.x - vertices_[i].x) * outward.x + (point.y - vertices_[i].y) * outward.y);
  }
  return beyond_px;
}

void RigidShape::add_ring(std::size_t vertices, double half_tangent, double even_px,
                          double odd_px) noexcept {
  UnitVector direction{0.0, -1.0};
  for (; size_ < vertices; ++size_) {
    const double radius_px = size_ % 2 == 0 ? even_px : odd_px;
    vertices_[size_] = {radius_px * direction.x, radius_px * direction.y};
    direction = direction.turned(half_tangent);
  }
}

void RigidShape::add_box(double half_x, double half_y) noexcept {
  vertices_ = {{{-half_x, -half_y}, {half_x, -half_y}, {half_x, half_y}, {-half_x, half_y}}};
  size_ = 4;
}

void RigidShape::add_angle(double arm_px, double thickness_px) noexcept {
  const double a = arm_px;
  const double t = thickness_px;
  const double c = 0.5 * (a * a + t * (a - t)) / (2.0 * a - t);  // of the area, from the corner
  vertices_ = {
      {{-c, -c}, {a - c, -c}, {a - c, t - c}, {t - c, t - c}, {t - c, a - c}, {-c, a - c}}};
  size_ = 6;
}

void RigidShape::join_vertices() noexcept {
  reach_px_ = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    const PlanePoint from = vertices_[i];
    const PlanePoint to = vertices_[(i + 1) % size_];
    const PlanePoint along{to.x - from.x, to.y - from.y};
    const double length = length_px(along);
    edges_[i] = {along, 1.0 / (length * length), {along.y / length, -along.x / length}};
    reach_px_ = std::max(reach_px_, length_px(from));
  }
  inner_px_ = -distance_px({0.0, 0.0});
}

namespace {

double square(double value) noexcept { return value * value; }

}  // namespace

ShapeCanvas::ShapeCanvas(std::int32_t width, std::int32_t height, double ground)
    : width_(width), height_(height), ground_(ground) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  pictures_.resize(pixels);
  brightness_.resize(pixels, ground);
  owners_.resize(pixels, kNone);
  touched_.resize(pixels);
}

void ShapeCanvas::begin() noexcept {
  ++picture_;
  size_ = 0;
}

void ShapeCanvas::begin(const MovingGround& ground) noexcept {
  begin();
  for (std::int32_t y = 0; y < height_; ++y) {
    for (std::int32_t x = 0; x < width_; ++x) {
      const std::uint32_t pixel = static_cast<std::uint32_t>(x + width_ * y);
      brightness_[pixel] = ground.brightness(x, y);
      pictures_[pixel] = picture_;
      owners_[pixel] = kNone;
      touched_[size_++] = pixel;
    }
  }
}

void ShapeCanvas::paint(const RigidShape& shape, const Pose& pose, double brightness,
                        std::int32_t object, const Texture* texture) noexcept {
  // Half a pixel beyond the outline, and where the shape was in the picture before.
  const double reach_px = pose.scale * shape.reach_px();
  const double inner_px = pose.scale * shape.inner_px();
  const double near_px = reach_px + 0.5 + 1.0;
  const double near_square = near_px * near_px;
  const double outside = square(reach_px + 0.5);
  const double inside = texture != nullptr ? 0.0 : square(std::max(inner_px - 0.5, 0.0));
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
      const PlanePoint point{(dx * pose.axis.x + dy * pose.axis.y) / pose.scale,
                             (dy * pose.axis.x - dx * pose.axis.y) / pose.scale};
      const double covered = shape.coverage(point, pose.scale);
      if (covered == 0.0) continue;
      const double own = texture != nullptr ? brightness * texture->at(point) : brightness;
      brightness_[pixel] = brightness_[pixel] * (1.0 - covered) + own * covered;
      owners_[pixel] = object;
    }
  }
}

}  // namespace asap
