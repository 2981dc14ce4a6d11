// Halves: two objects that were born as one. Their track is long, yet its events do not lie on one
// outline, with nobody near whose edges these could be; and each half of its cells shows both
// polarities, as an object in motion does and a single edge does not; and they come nearer or part,
// as the ends of one long object do not. Such a track is cut across its long axis, and both halves
// have an id at once: as a newborn the second would be merged again.
// One thread, at the tick. O(cells in a window), allocates in the constructor only.
// Source: own design.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "algorithms/fast/contour.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/owner_grid.hpp"
#include "algorithms/fast/split.hpp"
#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

// Whether a track, alone, is long and does not have one outline. noise_hz: per pixel.
bool looks_double(const Track& track, const Contour& contour, const Life& life, float noise_hz,
                  const GateRule& gate) noexcept;

// For long enough to look at its halves.
inline bool is_double(const Life& life) noexcept {
  constexpr float kSure_s = 0.03F;
  return life.double_s >= kSure_s;
}

class HalfFinder {
 public:
  using Part = PartFinder::Part;

  explicit HalfFinder(const CellMap& map);

  // The two halves of what the slot owned lately, if each could be an object; else none. The one
  // where the track is predicted comes first. Valid until the next call.
  std::span<const Part> find(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot,
                             Stamp now) noexcept;

 private:
  static constexpr int kMaxHalf = 24;  // cells

  struct Place {
    float x;  // px
    float y;
    std::size_t cell;
    std::int8_t sign;
  };

  void gather(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot, Stamp now) noexcept;
  std::size_t cut() noexcept;
  bool is_whole(std::span<const Place> places) const noexcept;
  Part part_of(std::size_t first, std::size_t count) const noexcept;

  CellMap map_;
  std::vector<Place> places_;
  std::vector<std::size_t> cells_;  // of the grid, those of the first half before the others
  std::array<Part, 2> halves_{};
};

// Whether the halves, if any, have come nearer or parted since they were first seen. Looks for as
// long as the track is doubtful; once they are, or there are none, the doubt begins anew.
bool have_moved_apart(Life& life, std::span<const HalfFinder::Part> halves) noexcept;

// Makes the child of a split a grown track beside its parent, whose past it shares; the parent has
// been left with its own share of the mass. The caller gives it an id.
void raise_twin(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child, float share,
                const GateRule& gate) noexcept;

}  // namespace asap::fast
