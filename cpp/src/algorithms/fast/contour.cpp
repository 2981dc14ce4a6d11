#include "algorithms/fast/contour.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace asap::inline v0_1::fast {

// Bins are centred on the axes and diagonals, where most whole pixels lie, so none is on a border.
DirectionTable::DirectionTable() : bins_{} {
  constexpr double kBin_rad = 2 * std::numbers::pi / kContourBins;
  for (int dy = -kReach; dy < kReach; ++dy) {
    for (int dx = -kReach; dx < kReach; ++dx) {
      const double bins = std::atan2(dy, dx) / kBin_rad + kContourBins;
      const auto bin = static_cast<std::size_t>(std::floor(bins + 0.5)) % kContourBins;
      bins_[static_cast<std::size_t>(dy + kReach) * kSide + static_cast<std::size_t>(dx + kReach)] =
          static_cast<std::uint8_t>(bin);
    }
  }
}

void Contour::push_sides(float dx, float dy, float growth) noexcept {
  sides = united(sides, {std::max(dx, sides.left - growth), std::max(dy, sides.top - growth),
                         std::min(dx, sides.right + growth), std::min(dy, sides.bottom + growth)});
}

}  // namespace asap::inline v0_1::fast
