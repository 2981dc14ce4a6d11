#include "algorithms/motion/motion_regions.hpp"

#include <algorithm>
#include <cmath>

namespace asap::inline v0_1::motion {
namespace {

constexpr std::size_t kFewestCells = 5;

}  // namespace

MotionRegions::MotionRegions(int width, int height, double min_px_s, double min_share)
    : min_px_s_(min_px_s),
      min_share_(min_share),
      columns_((static_cast<std::size_t>(width) + kCell_px - 1) / kCell_px),
      rows_((static_cast<std::size_t>(height) + kCell_px - 1) / kCell_px),
      cells_(columns_ * rows_),
      flags_(cells_.size()),
      regions_of_(cells_.size()) {
  component_.reserve(cells_.size());
  parts_.reserve(kMost);
  regions_.reserve(kMost);
}

std::span<const Region> MotionRegions::find(std::span<const FlowSample> samples,
                                            const BackgroundMotion& background) noexcept {
  vote(samples, background);
  flag(background);
  connect();
  gather(samples, background);
  return regions_;
}

void MotionRegions::Sums::add(const FlowSample& sample, double value, double weight) noexcept {
  const double nx = static_cast<double>(sample.nx);
  const double ny = static_cast<double>(sample.ny);
  xx += weight * nx * nx;
  xy += weight * nx * ny;
  yy += weight * ny * ny;
  x += weight * value * nx;
  y += weight * value * ny;
}

void MotionRegions::Sums::add(const Sums& other, double weight) noexcept {
  xx += weight * other.xx;
  xy += weight * other.xy;
  yy += weight * other.yy;
  x += weight * other.x;
  y += weight * other.y;
}

// A lone edge says nothing about the motion along itself: there the shift is the smallest.
Eigen::Vector2d MotionRegions::Sums::solve() const noexcept {
  const double ridge = 0.025 * (xx + yy);
  const double a = xx + ridge;
  const double c = yy + ridge;
  const double determinant = a * c - xy * xy;
  if (!(determinant > 0)) return Eigen::Vector2d::Zero();
  return {(c * x - xy * y) / determinant, (a * y - xy * x) / determinant};
}

// What the solution takes off the sum of squares.
double MotionRegions::Sums::gain(const Eigen::Vector2d& solution) const noexcept {
  return solution.x() * x + solution.y() * y;
}

void MotionRegions::vote(std::span<const FlowSample> samples,
                         const BackgroundMotion& background) noexcept {
  constexpr double kMost_sigma = 3;  // what one flow event says at most
  std::fill(cells_.begin(), cells_.end(), Sums{});
  for (const FlowSample& sample : samples) {
    const double sigma = background.sigma() * flow_error_px_s(sample);
    const double most = kMost_sigma * sigma;
    const double residual = background.frame().residual(sample, background.motion());
    cells_[cell(sample)].add(sample, std::clamp(residual, -most, most), 1 / (sigma * sigma));
  }
}

void MotionRegions::flag(const BackgroundMotion& background) noexcept {
  constexpr double kSignificant =
      20;  // of a chi square of two degrees of freedom; neighbours' errors are alike
  for (std::size_t row = 0; row < rows_; ++row) {
    for (std::size_t column = 0; column < columns_; ++column) {
      const std::size_t middle = row * columns_ + column;
      Sums sums{};
      for_each_around(column, row, [&](std::size_t cell) {
        sums.add(cells_[cell], cell == middle ? 1.0 : 0.5);
      });
      const Eigen::Vector2d shift = sums.solve();
      const Eigen::Vector2d place = cell_centre(column, row);
      const double speed = background.frame().velocity(background.motion(), place).norm();
      flags_[middle] =
          sums.gain(shift) > kSignificant && shift.norm() > min_px_s_ + min_share_ * speed;
    }
  }
}

void MotionRegions::connect() noexcept {
  std::fill(regions_of_.begin(), regions_of_.end(), kNone);
  parts_.clear();
  for (std::size_t first = 0; first < flags_.size() && parts_.size() < kMost; ++first) {
    if (flags_[first] == 0) continue;
    collect(first);
    if (component_.size() < kFewestCells) continue;
    Parts parts;
    for (const std::uint32_t cell : component_) {
      regions_of_[cell] = static_cast<std::uint8_t>(parts_.size());
      parts.centre += cell_centre(cell % columns_, cell / columns_);
    }
    parts.centre /= static_cast<double>(component_.size());
    parts_.push_back(parts);
  }
}

// The flagged cells that are connected to the first by sides or corners lose their flag.
void MotionRegions::collect(std::size_t first) noexcept {
  component_.clear();
  const auto take = [&](std::size_t cell) {
    if (flags_[cell] == 0) return;
    flags_[cell] = 0;
    component_.push_back(static_cast<std::uint32_t>(cell));
  };
  take(first);
  for (std::size_t i = 0; i < component_.size(); ++i) {
    for_each_around(component_[i] % columns_, component_[i] / columns_, take);
  }
}

// A flow event of a region's cells belongs to it as far as it fits the region's velocity and not
// the background's.
void MotionRegions::gather(std::span<const FlowSample> samples,
                           const BackgroundMotion& background) noexcept {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    for (Parts& parts : parts_) parts.begin(round > 0);
    for (const FlowSample& sample : samples) {
      const std::uint8_t number = regions_of_[cell(sample)];
      if (number == kNone) continue;
      const double error = background.sigma() * flow_error_px_s(sample);
      const double residual = background.frame().residual(sample, background.motion());
      parts_[number].add(sample, error, 1 - robust_share(residual / error));
    }
  }
  regions_.clear();
  for (const Parts& parts : parts_) {
    if (parts.weight > 0) regions_.push_back(region_of(parts));
  }
}

void MotionRegions::Parts::begin(bool has_one) noexcept {
  if (has_one) velocity = sums.solve();
  Parts fresh;
  fresh.centre = centre;
  fresh.velocity = velocity;
  fresh.has_velocity = has_one;
  *this = fresh;
}

void MotionRegions::Parts::add(const FlowSample& sample, double error, double share) noexcept {
  const double speed = static_cast<double>(sample.speed);
  if (has_velocity) {
    const double fitting = velocity.x() * static_cast<double>(sample.nx) +
                           velocity.y() * static_cast<double>(sample.ny);
    share *= robust_share((speed - fitting) / error);
  }
  const Eigen::Vector2d place(sample.x, sample.y);
  sums.add(sample, speed, share / (error * error));
  weight += share;
  mean += share * place;
  square += share * place.cwiseAbs2();
  t_last = sample.t;
}

// The cells tell the middle, also where one edge has most of the flow; the flow tells the size.
Region MotionRegions::region_of(const Parts& parts) noexcept {
  constexpr double kHalf_sigma = 1.75;  // half the length of a bar is 1.73 standard deviations
  const Eigen::Vector2d mean = parts.mean / parts.weight;
  const Eigen::Vector2d variance = parts.square / parts.weight - mean.cwiseAbs2();
  return {.centre = parts.centre,
          .half_size = kHalf_sigma * variance.cwiseMax(1).cwiseSqrt(),
          .velocity = parts.sums.solve(),
          .size = std::lround(parts.weight),
          .t_last = parts.t_last};
}

}  // namespace asap::inline v0_1::motion
