// OwnerCellMerge: which clusters of the first design become one. A tentative one joins its nearest
// neighbour at once; of two confirmed ones it takes similar velocities for ten ticks. The cells of
// the one that goes are those of the other from then on. One thread, at the tick. O(clusters^2),
// and O(cells) per merge; allocates in the constructor only.
// Source: own design.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/association.hpp"
#include "algorithms/fast/track.hpp"

namespace asap {

class OwnerCellMerge {
 public:
  using Slot = fast::Tracks::Slot;

  static constexpr int kTicks = 10;

  OwnerCellMerge(const fast::CellMap& map, std::size_t slots, int radius_px);

  // Joins one pair with a tentative cluster in it. Returns the one to be removed, or kNone.
  Slot join_tentative(fast::Tracks& tracks, fast::OwnerGrid& owners) const noexcept;

  // Once per tick: notes for how long confirmed clusters have had their partners.
  void hold(const fast::Tracks& tracks) noexcept;

  // Joins one pair that has held for long enough. Returns the one to be removed, or kNone.
  Slot join_confirmed(fast::Tracks& tracks, fast::OwnerGrid& owners) const noexcept;

  // A slot begins anew.
  void forget(Slot slot) noexcept { partners_[slot] = {}; }

 private:
  struct Partner {
    Slot slot = fast::Tracks::kNone;
    std::uint16_t generation = 0;
    int ticks = 0;
  };

  Slot nearest_to(const fast::Tracks& tracks, Slot slot) const noexcept;
  Slot join(fast::Tracks& tracks, fast::OwnerGrid& owners, Slot a, Slot b) const noexcept;

  std::size_t cells_;
  float reach2_;  // px^2
  std::vector<Partner> partners_;
};

}  // namespace asap
