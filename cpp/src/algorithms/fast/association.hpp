// Association: which track takes an event. OwnerGrid remembers per cell of a few px which track
// took the last event there; its answer is right for most events. CoarseIndex finds the tracks near
// a pixel for the others. Tracks in contact compete for each event by how well it fits their
// outlines; the owner of the cell has an advantage. CellMap says where the cells lie. One thread.
// O(1) per event, O(partners) in contact; allocates in the constructors only.
// Source: own design.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

// ---- cells ----

// Square cells, with a border of one cell around the frame. OwnerGrid and BirthGrid share it.
class CellMap {
 public:
  CellMap(int width, int height) noexcept
      : stride_((static_cast<std::size_t>(width - 1) >> kShift) + 3),
        rows_((static_cast<std::size_t>(height - 1) >> kShift) + 3) {}

  std::size_t size() const noexcept { return stride_ * rows_; }
  std::size_t stride() const noexcept { return stride_; }
  std::size_t rows() const noexcept { return rows_; }

  // Precondition: the pixel lies in the frame.
  std::size_t cell(std::size_t x, std::size_t y) const noexcept {
    return ((y >> kShift) + 1) * stride_ + (x >> kShift) + 1;
  }

  // Cells of the frame, at most `half` columns and rows from the one nearest to a position.
  struct Window {
    int left = 0;
    int top = 0;
    int columns = 0;
    int rows = 0;
  };
  Window window(float x, float y, int half) const noexcept {
    const int column = nearest_column(x);
    const int row = nearest_row(y);
    const int left = std::max(1, column - half);
    const int top = std::max(1, row - half);
    return {left, top, std::min(static_cast<int>(stride_) - 2, column + half) - left + 1,
            std::min(static_cast<int>(rows_) - 2, row + half) - top + 1};
  }

  // Column or row of the cell in the frame that is nearest to a position.
  int nearest_column(float x) const noexcept { return nearest(x, stride_); }
  int nearest_row(float y) const noexcept { return nearest(y, rows_); }

  // px, the middle of a column or row.
  float centre(std::size_t index) const noexcept {
    constexpr float kSide = kCell_px;
    return (static_cast<float>(index) - 1) * kSide + (kSide - 1) / 2;
  }

  int cells_in(float px) const noexcept { return static_cast<int>(px) >> kShift; }

  // Calls visit(cell) for the eight cells around one that is not in the border.
  template <class Visit>
  void for_each_neighbour(std::size_t cell, Visit&& visit) const noexcept {
    for (const std::size_t row : {cell - stride_, cell + stride_}) {
      visit(row - 1);
      visit(row);
      visit(row + 1);
    }
    visit(cell - 1);
    visit(cell + 1);
  }

 private:
  static constexpr int kShift = std::countr_zero(static_cast<unsigned>(kCell_px));

  static int nearest(float position, std::size_t cells) noexcept {
    const auto last = static_cast<float>(cells - 2);
    const float index = position / static_cast<float>(kCell_px) + 1;
    return static_cast<int>(std::clamp(index, 1.0F, last));
  }

  std::size_t stride_;
  std::size_t rows_;
};

// ---- the owner of a cell ----

// An entry is valid while it is young and the slot still has the noted generation, so that all
// cells of a deleted track become stale at once.
class OwnerGrid {
 public:
  struct Cell {
    Stamp stamp;
    std::uint16_t generation;
    std::uint8_t slot;  // there are 256 at most
    bool on = false;    // polarity of the last event
  };

  explicit OwnerGrid(const CellMap& map) : cells_(map.size()), scrubber_(map.size()) {}

  void clear(Stamp now) noexcept {
    std::fill(cells_.begin(), cells_.end(), Cell{long_before(now), 0, 0});
  }

  Cell& operator[](std::size_t cell) noexcept { return cells_[cell]; }
  const Cell& operator[](std::size_t cell) const noexcept { return cells_[cell]; }

  void give(std::span<const std::size_t> cells, std::size_t slot,
            std::uint16_t generation) noexcept {
    for (const std::size_t cell : cells) {
      cells_[cell].slot = static_cast<std::uint8_t>(slot);
      cells_[cell].generation = generation;
    }
  }

  void scrub(Stamp now, std::uint64_t elapsed_us) noexcept {
    scrubber_.scrub(cells_.data(), now, elapsed_us,
                    [](Cell& cell) -> Stamp& { return cell.stamp; });
  }

 private:
  std::vector<Cell> cells_;
  Scrubber scrubber_;
};

// ---- the tracks near a pixel ----

// Cells of 32 px, each with a linked list of the slots of the tracks that lie in it. A position
// outside the frame belongs to the nearest cell.
class CoarseIndex {
 public:
  using Slot = Tracks::Slot;
  static constexpr Slot kNone = kNoSlot;

  CoarseIndex(int width, int height, std::size_t slots)
      : columns_(cells_along(width)),
        rows_(cells_along(height)),
        stride_(static_cast<std::size_t>(columns_) + 2),
        first_(stride_ * (static_cast<std::size_t>(rows_) + 2)),
        links_(slots) {
    clear();
  }

  void clear() noexcept {
    std::fill(first_.begin(), first_.end(), kNone);
    std::fill(links_.begin(), links_.end(), Link{});
  }

  void place(Slot slot, float x, float y) noexcept {
    const auto cell = static_cast<std::uint32_t>(cell_of(x, y));
    if (links_[slot].cell == cell) return;
    remove(slot);
    Link& link = links_[slot];
    link = {cell, kNone, first_[cell]};
    if (link.next != kNone) links_[link.next].previous = slot;
    first_[cell] = slot;
  }

  void remove(Slot slot) noexcept {
    Link& link = links_[slot];
    if (link.cell == kNowhere) return;
    if (link.next != kNone) links_[link.next].previous = link.previous;
    (link.previous != kNone ? links_[link.previous].next : first_[link.cell]) = link.next;
    link = {};
  }

  // Calls visit(slot) for the tracks in the 3 x 3 cells around a pixel of the frame.
  template <class Visit>
  void for_each_around(std::size_t x, std::size_t y, Visit&& visit) const noexcept {
    const std::size_t corner = (y >> kShift) * stride_ + (x >> kShift);
    for (std::size_t row = corner; row <= corner + 2 * stride_; row += stride_) {
      for (std::size_t cell = row; cell < row + 3; ++cell) {
        for (Slot slot = first_[cell]; slot != kNone; slot = links_[slot].next) visit(slot);
      }
    }
  }

 private:
  static constexpr int kShift = 5;
  static constexpr std::uint32_t kNowhere = 0;  // a border cell

  struct Link {
    std::uint32_t cell = kNowhere;
    Slot previous = kNone;
    Slot next = kNone;
  };

  static int cells_along(int side) noexcept { return ((side - 1) >> kShift) + 1; }

  static std::size_t index_along(float position, int cells) noexcept {
    const float last = static_cast<float>((cells << kShift) - 1);
    return (static_cast<std::size_t>(std::clamp(position, 0.0F, last)) >> kShift) + 1;
  }

  std::size_t cell_of(float x, float y) const noexcept {
    return index_along(y, rows_) * stride_ + index_along(x, columns_);
  }

  int columns_;
  int rows_;
  std::size_t stride_;  // a border of one cell lies around the frame
  std::vector<Slot> first_;
  std::vector<Link> links_;
};

// ---- contact ----

// The cost of assigning the event to a track: the residual in standard deviations (factor 1.5) if
// the outline is known, else the distance from where an outline usually lies in the gate.
inline float contact_cost(const Track& track, const Contour& contour, const Innovation& nu,
                          const DirectionTable& directions) noexcept {
  const float distance = length(nu.dx, nu.dy);
  const std::size_t bin = directions.bin(nu.dx, nu.dy, distance);
  if (!contour.known(bin)) return std::abs(6 * std::sqrt(gate_value(track, nu)) - 4);
  return 1.5F * std::abs(contour.residual(bin, distance)) /
         std::sqrt(contour.variance + kContactVariance_px2);
}

// A track that takes an event, and the event's place in it.
struct Taker {
  Tracks::Slot slot;
  Innovation nu;
};

// The one with the least cost among the owner, whose gate accepts the event, and its partners.
inline Taker associate_in_contact(const Tracks& tracks, const Taker& owner, Stamp now,
                                  const Event& event, const DirectionTable& directions) noexcept {
  const auto cost_of = [&](const Taker& one) {
    return contact_cost(tracks[one.slot], tracks.contour(one.slot), one.nu, directions);
  };
  Taker best = owner;
  float min = kOwnerCost * cost_of(owner);
  for (std::uint8_t i = 0; i < tracks[owner.slot].partners; ++i) {
    const Tracks::Slot partner = tracks.state(owner.slot).partners[i];
    const Taker other{partner, innovation_of(tracks[partner], now, event)};
    if (!tracks[partner].has_id() || !accepts(tracks[partner], other.nu)) continue;
    const float cost = cost_of(other);
    if (!(cost < min)) continue;
    min = cost;
    best = other;
  }
  return best;
}

}  // namespace asap::inline v0_1::fast
