// RigidShape and ShapeCanvas: the shapes of moving objects, and the picture that they make.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "study/scenes/rigid_motion.hpp"
#include "study/scenes/texture.hpp"
#include "synthetic/plane.hpp"

namespace asap {

enum class ShapeKind : std::uint8_t {
  kDisk,
  kSquare,
  kRectangle,
  kTriangle,
  kStar,
  kBar,
  kAngle,
  kRing
};

// The outline of a moving object in its own frame: where it ends, how much of a pixel it covers,
// where its corners are. "Radius" r is the disk's radius, the square's half-side and the longer
// half-side of the rectangle (r x r/2); the triangle's corners lie at 1.2 r, the star's ten in turn
// at 1.3 r and 0.5 r. Three kinds have a thickness t: the bar (2 r x t), the angle (an L of two
// arms r long, about its centre of area) and the ring (r is its outer radius). Immutable, any
// thread, no allocation; O(vertices) near the outline, O(1) elsewhere.
class RigidShape {
 public:
  static constexpr std::size_t kKinds = 5;  // without a thickness
  static constexpr double kMaxRadius_px = 1000.0;

  explicit RigidShape(ShapeKind kind, double radius_px, double thickness_px = 0.0);

  // Signed distance from the outline, px; negative inside.
  double distance_px(PlanePoint point) const noexcept;

  // Of the pixel at this point where the shape is drawn `scale` times as large, 0 to 1:
  // clamp(0.5 - distance).
  double coverage(PlanePoint point, double scale) const noexcept;

  // The farthest that the outline gets from the centre.
  double reach_px() const noexcept { return reach_px_; }
  // The nearest that it gets; 0 or less where the centre is not inside.
  double inner_px() const noexcept { return inner_px_; }

  // In order around the outline; none for a disk or a ring.
  std::span<const PlanePoint> vertices() const noexcept { return {vertices_.data(), size_}; }

 private:
  struct Edge {
    PlanePoint along;
    double inverse_square;  // 1 / length^2
    PlanePoint outward;     // of length 1
  };
  static constexpr std::size_t kMaxVertices = 10;

  void add_ring(std::size_t vertices, double half_tangent, double even_px, double odd_px) noexcept;
  void add_box(double half_x, double half_y) noexcept;
  void add_angle(double arm_px, double thickness_px) noexcept;
  void join_vertices() noexcept;
  double beyond_edges_px(PlanePoint point) const noexcept;

  std::array<PlanePoint, kMaxVertices> vertices_{};
  std::array<Edge, kMaxVertices> edges_{};  // from the vertex of the same number to the next
  std::size_t size_ = 0;
  double reach_px_;
  double hole_px_;  // radius of a ring's hole
  double inner_px_;
  bool convex_ = true;
};

// The picture of moving shapes on an even ground, kept up to date around them only: begin(),
// paint() every shape in the same order, then read the pixels that may have changed. What is
// painted later lies on top; the last object that covered a pixel owns it, also after it left. One
// thread; O(pixels near a shape) per paint(), memory fixed by the constructor.
class ShapeCanvas {
 public:
  static constexpr std::int32_t kNone = -1;

  ShapeCanvas(std::int32_t width, std::int32_t height, double ground);

  void begin() noexcept;

  // The same before a ground that moves: every pixel may have changed, and what left it owns it no
  // longer.
  void begin(const MovingGround& ground) noexcept;

  // Between two pictures a shape may move by 1 px at most, and not shrink. `texture`: multiplies
  // the brightness. `object` may be kNone.
  void paint(const RigidShape& shape, const Pose& pose, double brightness, std::int32_t object,
             const Texture* texture = nullptr) noexcept;

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
