// The random probes of the published rule: UniformProbe draws a live event of a cluster; ProbeIndex
// knows which clusters have one near a pixel, so that the others need no probe. One thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/cell_grid.hpp"
#include "algorithms/key_set.hpp"
#include "core/random.hpp"

namespace asap::inline v0_1 {

// Names one draw, whatever the order in which the draws of an event are made.
struct ProbeDraw {
  std::uint64_t event;    // number of the event in the stream
  std::uint64_t cluster;  // creation number of the cluster
  std::uint64_t probe;    // 0 .. kappa - 1
};

// Draws one live event of a cluster, uniformly and with replacement, from a sequential stream of
// core/random.hpp: the same seed and the same events give the same draws on every platform. O(1),
// no allocation. Another sampler may use the draw's name instead of a stream of its own.
class UniformProbe {
 public:
  explicit UniformProbe(std::uint64_t seed) noexcept : random_(seed) {}

  // Returns member(i) for an i in [0, count), count < 2^32.
  template <class Member>
  auto operator()(const ProbeDraw&, std::uint64_t count, Member&& member) noexcept {
    return member((random_(draws_++) >> 32) * count >> 32);
  }

  void clear() noexcept { draws_ = 0; }

 private:
  CounterRandom random_;
  std::uint64_t draws_ = 0;
};

// A cluster in the index holds one of 128 keys. Per cell stand the set of keys with an event in it
// and the counts behind the set; per key a dense array of its events, so a uniform draw is one
// look-up. add, remove, member: O(1); near: nine cells; release: O(events of the key). Allocates in
// the constructor only. A cluster that gets no key must be probed on every event instead.
class ProbeIndex {
 public:
  using Key = KeySet::Key;
  using Position = std::uint16_t;
  static constexpr Key kNoKey = -1;

  // `capacity`: of the event window.
  ProbeIndex(std::size_t cells, std::size_t capacity)
      : capacity_(capacity),
        keys_(cells),
        counts_(cells * KeySet::kKeys),
        members_(capacity * KeySet::kKeys),
        places_(capacity) {}

  // A key for the cluster in `slot`, without events; kNoKey when all are taken.
  Key acquire(std::uint16_t slot) noexcept {
    if (free_.empty()) return kNoKey;
    const Key key = free_.lowest();
    free_.erase(key);
    owner_[at(key)] = slot;
    size_[at(key)] = 0;
    return key;
  }

  // Gives the key back with all its events; cell_of(position) is an event's cell.
  template <class CellOf>
  void release(Key key, CellOf&& cell_of) noexcept {
    for (std::size_t i = 0; i < size_[at(key)]; ++i) {
      const std::size_t cell = cell_of(member(key, i));
      count(key, cell) = 0;
      keys_[cell].erase(key);
    }
    free_.insert(key);
  }

  void add(Key key, std::size_t cell, Position position) noexcept {
    if (count(key, cell)++ == 0) keys_[cell].insert(key);
    const std::uint16_t place = size_[at(key)]++;
    members_[at(key) * capacity_ + place] = position;
    places_[position] = place;
  }

  void remove(Key key, std::size_t cell, Position position) noexcept {
    if (--count(key, cell) == 0) keys_[cell].erase(key);
    const Position last = member(key, --size_[at(key)]);
    members_[at(key) * capacity_ + places_[position]] = last;
    places_[last] = places_[position];
  }

  // The keys with an event in the 3 x 3 cells around `cell`.
  KeySet near(const CellGrid& grid, CellGrid::Cell cell) const noexcept {
    KeySet found;
    grid.for_each_around(cell, [&](std::size_t c) { found |= keys_[c]; });
    return found;
  }

  std::uint16_t owner(Key key) const noexcept { return owner_[at(key)]; }

  // Event i of the key, in no particular order.
  Position member(Key key, std::size_t i) const noexcept {
    return members_[at(key) * capacity_ + i];
  }

  void clear() noexcept {
    std::fill(keys_.begin(), keys_.end(), KeySet{});
    std::fill(counts_.begin(), counts_.end(), std::uint16_t{0});
    free_ = KeySet::all();
  }

 private:
  static std::size_t at(Key key) noexcept { return static_cast<std::size_t>(key); }
  std::uint16_t& count(Key key, std::size_t cell) noexcept {
    return counts_[cell * KeySet::kKeys + at(key)];
  }

  std::size_t capacity_;
  KeySet free_ = KeySet::all();
  std::array<std::uint16_t, KeySet::kKeys> owner_{};
  std::array<std::uint16_t, KeySet::kKeys> size_{};
  std::vector<KeySet> keys_;           // [cell]
  std::vector<std::uint16_t> counts_;  // [cell][key]
  std::vector<Position> members_;      // [key][place]
  std::vector<std::uint16_t> places_;  // [position]: place of the event among its key's members
};

}  // namespace asap::inline v0_1
