// EventWindow: the last S events of all clusters. A ring of exactly S entries: once it is full, the
// oldest event stands where the next one will go. The events of one cluster form a chain, a
// circular doubly linked list through the entries, so an event leaves and two chains join in O(1).
// Allocates in the constructor only. A chain is named by any of its positions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

class EventWindow {
 public:
  using Position = std::uint16_t;

  struct Entry {
    std::int64_t t;
    std::uint16_t x;
    std::uint16_t y;
    std::uint16_t cell;
    std::uint16_t cluster;
    Position previous;
    Position next;
  };

  explicit EventWindow(std::size_t capacity) : entries_(capacity) {}

  std::size_t capacity() const noexcept { return entries_.size(); }
  bool full() const noexcept { return full_; }

  // Where the next event goes. Once the window is full: the oldest event, to be unchained first.
  Position cursor() const noexcept { return cursor_; }

  // The timestamp of the oldest event. Precondition: one was appended.
  std::int64_t oldest_t() const noexcept { return entries_[full_ ? cursor_ : 0].t; }

  Entry& operator[](Position position) noexcept { return entries_[position]; }
  const Entry& operator[](Position position) const noexcept { return entries_[position]; }

  // Writes the event at the cursor, as a chain of its own.
  Position append(const Event& event, std::uint16_t cell, std::uint16_t cluster) noexcept {
    const Position position = cursor_;
    entries_[position] = {.t = event.t,
                          .x = event.x,
                          .y = event.y,
                          .cell = cell,
                          .cluster = cluster,
                          .previous = position,
                          .next = position};
    if (++cursor_ == capacity()) {
      cursor_ = 0;
      full_ = true;
    }
    return position;
  }

  // Makes one chain of two.
  void join(Position a, Position b) noexcept {
    std::swap(entries_[a].next, entries_[b].next);
    entries_[entries_[a].next].previous = a;
    entries_[entries_[b].next].previous = b;
  }

  // Takes one event out of its chain.
  void unchain(Position position) noexcept {
    const Entry& entry = entries_[position];
    entries_[entry.previous].next = entry.next;
    entries_[entry.next].previous = entry.previous;
  }

  // Calls visit(position) for every event of the chain, in any order.
  template <class Visit>
  void for_each(Position member, Visit&& visit) const noexcept {
    Position position = member;
    do {
      visit(position);
      position = entries_[position].next;
    } while (position != member);
  }

  void clear() noexcept {
    cursor_ = 0;
    full_ = false;
  }

 private:
  std::vector<Entry> entries_;
  Position cursor_ = 0;
  bool full_ = false;
};

}  // namespace asap::inline v0_1
