// CoarseIndex: which clusters are near a pixel. Cells of 32 px, each with a chained list of the
// slots of the clusters that lie in it, positions outside the frame in the nearest cell. One
// thread. O(1) to move a cluster; allocates in the constructor only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap::fast {

class CoarseIndex {
 public:
  using Slot = std::uint16_t;
  static constexpr Slot kNone = 0xffff;

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

  // Calls visit(slot) for the clusters in the 3 x 3 cells around a pixel of the frame.
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

}  // namespace asap::fast
