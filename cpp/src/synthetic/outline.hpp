// Outline: the edges of dark shapes on a bright ground, as points about 1 px apart with their
// normals, moved as one. An edge that sweeps one square pixel crosses kThresholds contrast
// thresholds, so a point releases an event whenever it has moved 1/kThresholds px along its normal:
// OFF where the dark shape advances, ON where it withdraws. Shapes do not hide each other.
// sweep() works in integers, kUnit-ths of a pixel: O(points), no allocation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/random.hpp"
#include "synthetic/block.hpp"
#include "synthetic/plane.hpp"

namespace asap::inline v0_1 {

class Outline {
 public:
  static constexpr std::int32_t kUnitBits = 10;
  static constexpr std::int32_t kUnit = 1 << kUnitBits;  // per px
  static constexpr std::int32_t kThresholds = 2;
  static constexpr double kLongestSweep_px = 0.8 / kThresholds;

  // Where the outline's origin lies, in kUnit-ths of a pixel.
  struct Place {
    std::int32_t x;
    std::int32_t y;
  };
  static Place place(double x_px, double y_px) noexcept;

  // The longest step, up to remaining_us, in which no outline of that speed moves too far.
  static std::int32_t step_us(double fastest_px_s, std::int64_t remaining_us) noexcept;

  // `random` draws how far each point is from its next threshold.
  explicit Outline(CounterRandom random) noexcept : random_(random) {}

  // Adds the contour of a dark polygon, vertices clockwise as seen (y down), moved by `offset`.
  void add(std::span<const PlanePoint> polygon, PlanePoint offset);

  void reserve(std::size_t points);
  void clear() noexcept { points_.clear(); }  // keeps the memory
  std::size_t size() const noexcept { return points_.size(); }

  // Events released per px of motion in this direction.
  double events_per_px(UnitVector direction) const noexcept;

  // Moves the outline during the block's step, by at most kLongestSweep_px: at most one event per
  // point.
  void sweep(Place from, Place to, TimeSortedBlock& block) noexcept;

 private:
  struct EdgePoint {
    std::int32_t x;  // kUnit-ths of a px
    std::int32_t y;
    std::int32_t step_x;  // outward normal in thresholds per px, times kThreshold / kUnit
    std::int32_t step_y;
    std::int32_t level;  // position between two thresholds, in [0, kThreshold)
  };

  static constexpr std::int32_t kThreshold = 1 << 24;

  CounterRandom random_;
  std::uint64_t drawn_ = 0;
  std::vector<EdgePoint> points_;
  std::vector<std::uint32_t> crossed_;  // scratch of sweep()
};

}  // namespace asap::inline v0_1
