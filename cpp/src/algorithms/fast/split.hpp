// Split: a track that has grown may hold two objects that came apart. The cells that it owns are
// grouped into connected parts; a part far from the one where the track is predicted becomes a
// track of its own. One thread, at the tick. O(cells in a window), allocates in the constructor
// only.
// Source: own design.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/owner_grid.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

class PartFinder {
 public:
  static constexpr std::size_t kMaxParts = 4;
  static constexpr int kReach_cells = 2;  // farther apart: not connected
  static constexpr std::size_t kMinCells = 4;

  struct Part {
    float x;  // px, mean of its cells
    float y;
    std::span<const std::size_t> cells;  // of the grid

    float distance(const Part& other) const noexcept { return length(x - other.x, y - other.y); }
  };

  explicit PartFinder(const CellMap& map);

  // The parts of what the slot owns around its predicted mean; valid until the next call.
  std::span<const Part> find(OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot, Stamp now,
                             std::int32_t link_us) noexcept;

 private:
  static constexpr int kMaxHalf = 24;  // cells
  static constexpr int kSide = 2 * kMaxHalf + 1;

  void mark(OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot, Stamp now,
            std::int32_t link_us, float x, float y, float reach_px) noexcept;
  void grow(std::size_t start) noexcept;
  Part part_of(std::size_t first) noexcept;

  CellMap map_;
  std::array<std::uint8_t, kSide * kSide> owned_{};  // and not in a part yet
  CellMap::Window window_;
  std::vector<std::size_t> cells_;
  std::array<Part, kMaxParts> parts_{};
};

// Of the cells of all parts.
float share_of(const PartFinder::Part& part, std::span<const PartFinder::Part> parts) noexcept;

// Whether a track, alone, has become much larger than it was.
bool has_grown(const Track& track, const Life& life) noexcept;

// The part nearest to where the Kalman filter predicts the track; null if there are not two.
const PartFinder::Part* home_of(std::span<const PartFinder::Part> parts, const Track& track,
                                const Life& life, Stamp now) noexcept;

// Starts the track anew at a part, with this share of its mass and rates.
void keep_part(Tracks& tracks, Tracks::Slot slot, const PartFinder::Part& part, float share,
               float cell_px, Stamp now) noexcept;

// Gives a new track at a part the parent's velocity and its share of the mass.
void inherit_part(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child,
                  const PartFinder::Part& part, float share, float cell_px) noexcept;

}  // namespace asap::fast
