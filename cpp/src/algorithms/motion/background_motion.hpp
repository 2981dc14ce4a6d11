// BackgroundMotion: the motion of the picture behind everything that moves on its own: shift, turn
// and zoom, from normal flow, robustly; and whether the flow says enough about it. One thread.
// O(samples) per fit; allocates in the constructor only.
// Source: iterated weighted least squares with the weights of Geman and McClure, "Statistical
// Methods for Tomographic Image Reconstruction", 1987.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "asap/algorithms/plane_flow.hpp"
#include "asap/core/event.hpp"

namespace asap::inline v0_1::motion {

// The velocity along the edge's normal, of one event.
struct FlowSample {
  std::int64_t t;
  std::uint16_t x;
  std::uint16_t y;
  float nx;  // the normal, in the direction of the motion
  float ny;
  float speed;  // px/s
};

// The error of a speed grows with it.
inline double flow_error_px_s(const FlowSample& sample) noexcept {
  return 10 + 0.15 * static_cast<double>(sample.speed);
}

// The weight of a residual of so many standard deviations, by Geman and McClure.
inline double robust_share(double sigmas) noexcept {
  const double ratio = 0.5 * sigmas;
  const double inverse = 1 / (1 + ratio * ratio);
  return inverse * inverse;
}

// vx and vy at the middle of the frame; turn and zoom times half its longer side: all px/s.
using Motion = Eigen::Vector4d;

class MotionFrame {
 public:
  MotionFrame(int width, int height) noexcept
      : middle_x_(0.5 * (width - 1)),
        middle_y_(0.5 * (height - 1)),
        scale_(2.0 / (width > height ? width : height)) {}

  Eigen::Vector2d velocity(const Motion& motion, const Eigen::Vector2d& place) const noexcept {
    const double dx = (place.x() - middle_x_) * scale_;
    const double dy = (place.y() - middle_y_) * scale_;
    return {motion[0] - motion[2] * dy + motion[3] * dx,
            motion[1] + motion[2] * dx + motion[3] * dy};
  }

  // What a motion times this row gives is the speed along the sample's normal.
  Motion row(const FlowSample& sample) const noexcept {
    const double dx = (sample.x - middle_x_) * scale_;
    const double dy = (sample.y - middle_y_) * scale_;
    const double nx = static_cast<double>(sample.nx);
    const double ny = static_cast<double>(sample.ny);
    return {nx, ny, ny * dx - nx * dy, nx * dx + ny * dy};
  }

  double residual(const FlowSample& sample, const Motion& motion) const noexcept {
    return static_cast<double>(sample.speed) - row(sample).dot(motion);
  }

  double scale() const noexcept { return scale_; }  // 1/px

 private:
  double middle_x_;
  double middle_y_;
  double scale_;
};

class BackgroundMotion {
 public:
  BackgroundMotion(int width, int height, std::size_t most_samples);

  // Fits the samples. False: unknown. `gamma`: the fraction of the events that is there.
  bool fit(std::span<const FlowSample> samples, double gamma) noexcept;

  void reset() noexcept { is_known_ = false; }

  // Those of the last fit.
  bool is_known() const noexcept { return is_known_; }
  const Motion& motion() const noexcept { return motion_; }
  const Eigen::Matrix4d& covariance() const noexcept { return covariance_; }
  // Standard deviation of the residuals of the background, in units of flow_error_px_s.
  double sigma() const noexcept { return sigma_; }

  const MotionFrame& frame() const noexcept { return frame_; }

 private:
  static constexpr std::uint32_t kBlocks = 4;  // of the frame, in each direction

  std::size_t cell(const FlowSample& sample) const noexcept {
    return sample.y / kCell_px * columns_ + sample.x / kCell_px;
  }
  // What the steps of a fit read of a sample.
  struct Equation {
    Motion row;
    double speed;
    double inverse_error;
    double weight;  // of a sample that fits
    std::size_t cell;
  };

  void prepare(std::span<const FlowSample> samples) noexcept;
  bool iterate(bool begins) noexcept;
  void measure_sigma() noexcept;
  void measure_covariance() noexcept;
  double residual(const Equation& equation) const noexcept {
    return equation.speed - equation.row.dot(motion_);
  }
  double robust_weight(const Equation& equation, double residual) const noexcept;
  bool is_covered(std::span<const FlowSample> samples, double gamma, bool is_fitted) const noexcept;

  static constexpr std::size_t kCell_px = 16;

  MotionFrame frame_;
  std::uint32_t width_;  // px
  std::uint32_t height_;
  std::size_t columns_;
  std::vector<std::uint32_t> counts_;  // samples of each cell
  std::vector<Motion> scores_;         // of each cell: the gradient at the solution
  std::vector<Equation> equations_;    // of each sample
  std::vector<double> errors_;         // of each sample
  Motion motion_ = Motion::Zero();
  Eigen::Matrix4d normal_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d covariance_ = Eigen::Matrix4d::Zero();
  double sigma_ = 1;
  bool is_known_ = false;
};

}  // namespace asap::inline v0_1::motion
