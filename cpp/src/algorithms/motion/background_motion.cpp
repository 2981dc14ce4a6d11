#include "algorithms/motion/background_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace asap::inline v0_1::motion {
namespace {

constexpr std::size_t kFewest = 20;  // samples, five for each parameter
constexpr int kSteps = 3;
constexpr double kLeastSigma = 0.05;

double square(double value) noexcept { return value * value; }

}  // namespace

BackgroundMotion::BackgroundMotion(int width, int height, std::size_t most_samples)
    : frame_(width, height),
      width_(static_cast<std::uint32_t>(width)),
      height_(static_cast<std::uint32_t>(height)),
      columns_((width_ + kCell_px - 1) / kCell_px),
      counts_(columns_ * ((height_ + kCell_px - 1) / kCell_px)),
      scores_(counts_.size()) {
  equations_.reserve(most_samples);
  errors_.reserve(most_samples);
}

bool BackgroundMotion::fit(std::span<const FlowSample> samples, double gamma) noexcept {
  const bool begins = !is_known_;
  is_known_ = false;
  if (samples.size() < kFewest || !is_covered(samples, gamma, false)) return false;
  prepare(samples);
  if (begins) {
    if (!iterate(true)) return false;
    measure_sigma();
  }
  for (int step = 0; step < kSteps; ++step) {
    if (!iterate(false)) return false;
  }
  measure_sigma();
  is_known_ = is_covered(samples, gamma, true);
  if (is_known_) measure_covariance();
  return is_known_;
}

// A cell with much flow weighs as much as one with little: else one textured thing is the ground.
void BackgroundMotion::prepare(std::span<const FlowSample> samples) noexcept {
  std::fill(counts_.begin(), counts_.end(), 0U);
  equations_.clear();
  for (const FlowSample& sample : samples) {
    const double inverse_error = 1 / flow_error_px_s(sample);
    equations_.push_back({.row = frame_.row(sample),
                          .speed = static_cast<double>(sample.speed),
                          .inverse_error = inverse_error,
                          .weight = square(inverse_error),
                          .cell = cell(sample)});
    ++counts_[equations_.back().cell];
  }
  for (Equation& equation : equations_) equation.weight /= counts_[equation.cell];
}

double BackgroundMotion::robust_weight(const Equation& equation, double residual) const noexcept {
  return equation.weight * robust_share(residual * equation.inverse_error / sigma_);
}

bool BackgroundMotion::iterate(bool begins) noexcept {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Motion right = Motion::Zero();
  for (const Equation& equation : equations_) {
    const double w = begins ? equation.weight : robust_weight(equation, residual(equation));
    const Motion weighted = w * equation.row;
    normal.noalias() += weighted * equation.row.transpose();
    right.noalias() += equation.speed * weighted;
  }
  const Eigen::LDLT<Eigen::Matrix4d> solver(normal);
  constexpr double kOneDirection = 1e-6;  // share of the trace, far above rounding
  if (!(solver.vectorD().minCoeff() > kOneDirection * normal.trace())) return false;
  motion_ = solver.solve(right);
  normal_ = normal;
  return motion_.allFinite();
}

void BackgroundMotion::measure_sigma() noexcept {
  errors_.clear();
  for (const Equation& equation : equations_) {
    errors_.push_back(std::abs(residual(equation)) * equation.inverse_error);
  }
  const auto middle = errors_.begin() + static_cast<std::ptrdiff_t>(errors_.size() / 2);
  std::nth_element(errors_.begin(), middle, errors_.end());
  constexpr double kOfMedian = 1.48;  // of a normal distribution
  sigma_ = std::max(kLeastSigma, kOfMedian * *middle);
}

// Of M-estimates whose errors are independent from cell to cell, but not within one.
void BackgroundMotion::measure_covariance() noexcept {
  std::fill(scores_.begin(), scores_.end(), Motion::Zero());
  for (const Equation& equation : equations_) {
    const double error = residual(equation);
    scores_[equation.cell] += robust_weight(equation, error) * error * equation.row;
  }
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  for (const Motion& score : scores_) scatter.noalias() += score * score.transpose();
  const Eigen::LDLT<Eigen::Matrix4d> solver(normal_);
  const Eigen::Matrix4d half = solver.solve(scatter);
  covariance_ = solver.solve(half.transpose());
}

// Whether flow lies all over the frame, and much of it in a third of the blocks; after a fit, the
// flow that fits.
bool BackgroundMotion::is_covered(std::span<const FlowSample> samples, double gamma,
                                  bool is_fitted) const noexcept {
  std::array<std::uint32_t, kBlocks * kBlocks> fitting{};
  std::array<std::uint32_t, kBlocks * kBlocks> all{};
  for (const FlowSample& sample : samples) {
    const std::uint32_t block =
        sample.y * kBlocks / height_ * kBlocks + sample.x * kBlocks / width_;
    const double speed = static_cast<double>(sample.speed);
    ++all[block];
    fitting[block] += !is_fitted || std::abs(frame_.residual(sample, motion_)) < 15 + 0.3 * speed;
  }
  int some = 0;
  int many = 0;
  for (std::size_t block = 0; block < all.size(); ++block) {
    some += fitting[block] >= std::max(1.0, 3 * gamma);
    many += fitting[block] >= std::max(3.0, 10 * gamma) && 2 * fitting[block] >= all[block];
  }
  return some >= 13 && many >= 5;
}

}  // namespace asap::inline v0_1::motion
