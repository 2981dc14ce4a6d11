// CentreGrid: which clusters have their centre in a cell. Per cell an intrusive doubly linked list
// of cluster slots, so entering, leaving and moving are O(1). Allocates in the constructor only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap::inline v0_1 {

class CentreGrid {
 public:
  using Slot = std::uint16_t;
  static constexpr Slot kNone = 0xffff;

  CentreGrid(std::size_t cells, std::size_t slots) : heads_(cells, kNone), nodes_(slots) {}

  // The clusters of a cell: for (slot = first(cell); slot != kNone; slot = next(slot)).
  Slot first(std::size_t cell) const noexcept { return heads_[cell]; }
  Slot next(Slot slot) const noexcept { return nodes_[slot].next; }

  void enter(Slot slot, std::uint16_t cell) noexcept {
    const Slot old_head = heads_[cell];
    nodes_[slot] = {.cell = cell, .previous = kNone, .next = old_head};
    if (old_head != kNone) nodes_[old_head].previous = slot;
    heads_[cell] = slot;
  }

  void leave(Slot slot) noexcept {
    const Node node = nodes_[slot];
    (node.previous == kNone ? heads_[node.cell] : nodes_[node.previous].next) = node.next;
    if (node.next != kNone) nodes_[node.next].previous = node.previous;
  }

  void move(Slot slot, std::uint16_t cell) noexcept {
    if (nodes_[slot].cell == cell) return;
    leave(slot);
    enter(slot, cell);
  }

  void clear() noexcept { std::fill(heads_.begin(), heads_.end(), kNone); }

 private:
  struct Node {
    std::uint16_t cell;
    Slot previous;
    Slot next;
  };

  std::vector<Slot> heads_;
  std::vector<Node> nodes_;
};

}  // namespace asap::inline v0_1
