// MovingShapes: events of shapes that move before an even ground, or before a textured one that
// moves as before a moving camera, or behind a fence, with exact truth: the object of every event,
// and where every object is. What the ground causes is labelled as noise. Each pixel sees the log
// of its brightness and has thresholds of its own (ContrastPixel); noise is added that knows
// nothing of the pixels. Motion goes in steps of 250 us, one block each. Thread and allocation as
// EventStream; the cost goes with the area of the shapes. Limits:
// python/laboratory/pages/scenes.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "asap/synthetic/streams.hpp"
#include "study/scenes/fence.hpp"
#include "study/scenes/limb.hpp"
#include "study/scenes/rigid_motion.hpp"
#include "study/scenes/rigid_shape.hpp"
#include "study/scenes/texture.hpp"
#include "synthetic/block.hpp"

namespace asap {

// The sensor model of one pixel: it remembers a reference level of log brightness and fires when
// the brightness is a threshold above or below. A change moves the reference even within the
// refractory time, in which the pixel is blind. O(changes) per step.
class ContrastPixel {
 public:
  static constexpr std::int64_t kRefractory_us = 300;

  struct Change {
    std::int32_t offset_us;  // after the start of the step, truncated
    bool on;
    friend bool operator==(const Change&, const Change&) = default;
  };

  ContrastPixel() = default;
  // Thresholds above 0; the brightness starts at `level`.
  ContrastPixel(double on, double off, double level, double reference) noexcept
      : on_(on), off_(off), level_(level), reference_(reference) {}

  // Brightness goes linearly to `level` in the step [start_us, start_us + step_us), which is no
  // longer than the refractory time: there is one event at most.
  std::optional<Change> move_to(double level, std::int64_t start_us, std::int32_t step_us) noexcept;

 private:
  double on_ = 0.25;
  double off_ = 0.25;
  double level_ = 0.0;
  double reference_ = 0.0;
  std::int64_t blind_until_us_ = INT64_MIN;
};

// A lamp: lit in the first half of each period, of the ground's brightness in the second.
struct Flicker {
  std::int64_t period_us = 0;  // a multiple of 500 us; 0: none
  std::int64_t begun_us = 0;   // before the start of the stream
};

struct MovingShape {
  ShapeKind kind = ShapeKind::kDisk;
  double radius_px = 8.0;
  double brightness = 0.08;  // 0.02 to 1; the ground's is 0.5
  RigidMotionConfig motion{};
  double thickness_px = 0.0;  // of a bar, an angle or a ring
  bool textured = false;      // 0.4 to 1.6 of its brightness, up to 1
  std::vector<LimbConfig> limbs{};
  Flicker flicker{};
};

// How far a shape gets from its centre at the start, its limbs included.
double reach_px(const MovingShape& shape);

struct MovingShapesConfig {
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::int64_t duration_us = 1'500'000;  // a multiple of 250 us
  std::int64_t t0_us = 0;
  double noise_hz = 0.5;  // background events per second and pixel
  std::uint64_t seed = 0;
  std::vector<MovingShape> shapes{};           // later ones hide earlier ones
  std::size_t decoys = 0;                      // the last shapes: no objects, their events noise
  std::optional<MovingGroundConfig> ground{};  // none: even, at rest
  std::optional<FenceConfig> fence{};
};

// The shapes that are objects.
std::span<const MovingShape> objects_of(const MovingShapesConfig& config) noexcept;

class MovingShapes final : public EventStream {
 public:
  static constexpr std::int32_t kStep_us = RigidMotion::kStep_us;
  static constexpr std::int32_t kNoise = -1;
  static constexpr double kGround = 0.5;

  explicit MovingShapes(const MovingShapesConfig& config);

  // The events of the next step that has any.
  [[nodiscard]] EventSpan next() noexcept override;

  // Of the block's events: the number of the shape in the configuration, or kNoise.
  std::span<const std::int32_t> labels() const noexcept { return {labels_.data(), size_}; }

  // Of the shapes during the block's step: at its start.
  std::span<const Pose> poses() const noexcept { return poses_; }

  const MovingShapesConfig& config() const noexcept { return config_; }
  std::span<const RigidShape> shapes() const noexcept { return shapes_; }

 private:
  void make_pixels();
  void paint(std::int64_t t_us) noexcept;
  double through_fence(std::uint32_t pixel, double brightness) const noexcept;
  void advance() noexcept;
  void see() noexcept;
  void merge(EventSpan seen, EventSpan noise) noexcept;

  MovingShapesConfig config_;
  std::vector<RigidShape> shapes_;
  std::vector<RigidMotion> motions_;
  std::vector<std::vector<Limb>> limbs_;
  std::vector<std::optional<Texture>> textures_;
  std::optional<MovingGround> ground_;
  std::optional<Fence> fence_;
  ShapeCanvas canvas_;
  BackgroundNoise noise_;
  std::vector<ContrastPixel> pixels_;
  std::vector<double> shown_;  // brightness of each pixel in the picture before
  TimeSortedBlock seen_block_;
  TimeSortedBlock noise_block_;
  std::vector<Event> events_;
  std::vector<std::int32_t> labels_;
  std::size_t size_ = 0;
  std::vector<Pose> poses_;
  std::int64_t elapsed_us_ = 0;
};

// The poses of all objects at 0, 250, 500 us ... up to and including the duration, step by step.
std::vector<Pose> poses_of(const MovingShapesConfig& config);

}  // namespace asap
