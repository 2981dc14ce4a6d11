// MotionRegions: where the flow asks for a shift beside the motion of the background. In cells of 8
// px, with their neighbours at half the weight, the shift is that of least squares on the
// residuals; a cell is flagged if it is significant and fast. Cells that touch are a region. One
// thread. O(samples + cells); allocates in the constructor only.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/motion/background_motion.hpp"

namespace asap::inline v0_1::motion {

struct Region {
  Eigen::Vector2d centre;     // px
  Eigen::Vector2d half_size;  // px, of its box
  Eigen::Vector2d velocity;   // px/s
  std::int64_t size;          // flow events that the background does not explain
  std::int64_t t_last;        // us, of the newest of them
};

class MotionRegions {
 public:
  static constexpr std::size_t kMost = 64;

  MotionRegions(int width, int height, double min_px_s, double min_share);

  // Valid until the next call. No more than the first kMost, from the top.
  std::span<const Region> find(std::span<const FlowSample> samples,
                               const BackgroundMotion& background) noexcept;

 private:
  static constexpr std::size_t kCell_px = 8;
  static constexpr std::uint8_t kNone = 0xff;

  // Sums over flow: the normal equations of a velocity.
  struct Sums {
    double xx = 0;
    double xy = 0;
    double yy = 0;
    double x = 0;
    double y = 0;

    void add(const FlowSample& sample, double value, double weight) noexcept;
    void add(const Sums& other, double weight) noexcept;
    Eigen::Vector2d solve() const noexcept;
    double gain(const Eigen::Vector2d& solution) const noexcept;
  };

  // A region while it is being made.
  struct Parts {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  // of the round before
    bool has_velocity = false;
    Sums sums{};
    double weight = 0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Vector2d square = Eigen::Vector2d::Zero();
    std::int64_t t_last = 0;

    void begin(bool has_one) noexcept;
    void add(const FlowSample& sample, double error, double share) noexcept;
  };

  std::size_t cell(const FlowSample& sample) const noexcept {
    return sample.y / kCell_px * columns_ + sample.x / kCell_px;
  }
  static Eigen::Vector2d cell_centre(std::size_t column, std::size_t row) noexcept {
    return {static_cast<double>(column * kCell_px) + 0.5 * (kCell_px - 1),
            static_cast<double>(row * kCell_px) + 0.5 * (kCell_px - 1)};
  }
  // Calls visit(cell) for the cell and those around it.
  template <class Visit>
  void for_each_around(std::size_t column, std::size_t row, Visit&& visit) const noexcept {
    for (std::size_t y = row > 0 ? row - 1 : 0; y < std::min(row + 2, rows_); ++y) {
      for (std::size_t x = column > 0 ? column - 1 : 0; x < std::min(column + 2, columns_); ++x) {
        visit(y * columns_ + x);
      }
    }
  }
  void vote(std::span<const FlowSample> samples, const BackgroundMotion& background) noexcept;
  void flag(const BackgroundMotion& background) noexcept;
  void connect() noexcept;
  void collect(std::size_t first) noexcept;
  void gather(std::span<const FlowSample> samples, const BackgroundMotion& background) noexcept;
  static Region region_of(const Parts& parts) noexcept;

  double min_px_s_;
  double min_share_;
  std::size_t columns_;
  std::size_t rows_;
  std::vector<Sums> cells_;
  std::vector<std::uint8_t> flags_;
  std::vector<std::uint8_t> regions_of_;  // number of each cell's region
  std::vector<std::uint32_t> component_;  // cells of the region in the making
  std::vector<Parts> parts_;
  std::vector<Region> regions_;
};

}  // namespace asap::inline v0_1::motion
