// Split: one track that holds two objects becomes two tracks. There are two cases. A track that has
// grown may hold objects that separated: its cells are grouped into connected parts, and a part far
// from the predicted one becomes a track of its own. A track that began with two unresolved objects
// is long, but its events do not lie on one outline and no other track is near; each half of its
// cells shows both polarities, as a moving object does and a single edge does not; the halves are
// not both long, as those of a bar are; and their distance changes, as that of the ends of one long
// object does not. It is cut across its long axis, and both halves have an id at once: a tentative
// half would be merged again. One thread, at the tick. O(cells in a window), allocates in the
// constructors only.
// Source: own design.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/fast/association.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

inline constexpr std::size_t kMinPartCells = 4;

struct Part {
  float x;  // px, mean of its cells
  float y;
  std::span<const std::size_t> cells;  // indices in the grid
  float spread_px = 0;  // of a half: standard deviation of its cells along the long axis

  float distance(const Part& other) const noexcept { return length(x - other.x, y - other.y); }
};

// ---- objects that separated ----

// Whether a track that is not in contact has become much larger than it was, and is so dense that
// the gaps between its cells are gaps between objects: events in the memory of a cell, per px of
// its extent.
bool extent_has_grown(const Track& track, const TrackState& state, float dense_per_px) noexcept;

class PartFinder {
 public:
  static constexpr std::size_t kMaxParts = 4;
  static constexpr int kReach_cells = 2;  // cells farther apart are not connected

  explicit PartFinder(const CellMap& map);

  // The connected parts of the slot's cells around its predicted mean. Valid until the next call.
  std::span<const Part> find(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot,
                             Stamp now, std::int32_t link_us) noexcept;

 private:
  static constexpr int kMaxHalf = 24;  // cells
  static constexpr int kSide = 2 * kMaxHalf + 1;

  void mark(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot, Stamp now,
            std::int32_t link_us, float x, float y, float reach_px) noexcept;
  void grow(std::size_t start) noexcept;
  Part part_of(std::size_t first) noexcept;

  CellMap map_;
  std::array<std::uint8_t, kSide * kSide>
      owned_{};  // 1: the slot owns the cell, and no part has it yet
  CellMap::Window window_;
  std::vector<std::size_t> cells_;
  std::array<Part, kMaxParts> parts_{};
};

// ---- unresolved objects ----

// Whether a track, with no other near, is long and its events do not lie on one outline. noise_hz:
// per pixel.
bool looks_unresolved(const Track& track, const Contour& contour, const TrackState& state,
                      float noise_hz) noexcept;

// Whether it has looked unresolved for long enough to look for its halves.
inline bool is_unresolved(const TrackState& state) noexcept {
  constexpr float kSure_s = 0.03F;
  return state.unresolved_s >= kSure_s;
}

class HalfFinder {
 public:
  explicit HalfFinder(const CellMap& map);

  // The two halves of the slot's recent cells if each may be an object, else none. The one where
  // the track is predicted comes first. Valid until the next call.
  std::span<const Part> find(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot,
                             Stamp now) noexcept;

 private:
  static constexpr int kMaxHalf = 24;  // cells

  struct OwnedCell {
    float x;  // px
    float y;
    std::size_t index;
    std::int8_t sign;
  };

  struct Spread {  // px, standard deviations
    float along;
    float across;

    // The halves of a bar do, those of two objects do not.
    bool lies_along() const noexcept {
      constexpr float kElongation = 2;  // ratio of variances
      return along * along > kElongation * across * across;
    }
  };

  struct Cut {
    std::size_t first;  // cells in the first half
    Point axis;         // the long one, of any length
  };

  void gather(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot, Stamp now) noexcept;
  Cut cut() noexcept;
  bool has_both_edges(std::span<const OwnedCell> cells) const noexcept;
  static Spread spread_of(Point axis, std::span<const OwnedCell> cells) noexcept;
  Part part_of(std::size_t first, std::size_t count, float spread_px) const noexcept;

  CellMap map_;
  std::vector<OwnedCell> owned_cells_;
  std::vector<std::size_t> cells_;  // indices in the grid, the first half before the other
  std::array<Part, 2> halves_{};
};

// Whether the distance of the halves, if any, has changed since they were first seen. If it has, or
// if there are none, the track counts as resolved until it looks unresolved again. Halves farther
// apart than two objects begin unresolved must also lie apart for their size: those of one object
// that comes near or turns part too, but grow with it.
bool have_parted(TrackState& state, std::span<const Part> halves, float birth_radius_px) noexcept;

// ---- splitting ----

// The share of the cells of all parts.
float share_of(const Part& part, std::span<const Part> parts) noexcept;

// The part nearest to where the Kalman filter predicts the track; null if there are not two.
const Part* part_at_prediction(std::span<const Part> parts, const Track& track,
                               const TrackState& state, Stamp now) noexcept;

// Restarts the track at a part, with this share of its mass and rates.
void restart_at_part(Tracks& tracks, Tracks::Slot slot, const Part& part, float share,
                     Stamp now) noexcept;

// Gives a new track at a part the parent's velocity and a share of its mass.
void begin_at_part(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child, const Part& part,
                   float share) noexcept;

// Confirms the child with the history of its parent, which has restarted with its own share of the
// mass. The caller gives it an id.
void confirm_child(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child, float share,
                   const GateRule& gate) noexcept;

}  // namespace asap::inline v0_1::fast
