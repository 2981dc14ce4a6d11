// OrphanGrid: counts, per small cell and with decay, the events that no cluster takes. Where the
// count of a cell and its neighbours is above what noise explains, a cluster is born. One thread.
// O(1) per event, allocates in the constructor only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/decay.hpp"
#include "algorithms/fast/owner_grid.hpp"
#include "algorithms/fast/stamp.hpp"

namespace asap::fast {

class OrphanGrid {
 public:
  OrphanGrid(const CellMap& map, float decay_s)
      : map_(map), decay_us_(1e6F * decay_s), cells_(map.size()), scrubber_(map.size()) {}

  void clear(Stamp now) noexcept {
    std::fill(cells_.begin(), cells_.end(), Cell{long_before(now), 0.0F});
  }

  // Counts one event; returns the sum around it: its own cell's count, the neighbours' with the
  // linear decay that reaches zero after twice the time constant.
  float count(std::size_t cell, Stamp now) noexcept {
    Cell& own = cells_[cell];
    own.events = own.events * decay(static_cast<float>(age_us(now, own.stamp)) / decay_us_) + 1;
    own.stamp = now;
    float sum = own.events;
    map_.for_each_neighbour(cell, [&](std::size_t neighbour) {
      const Cell& other = cells_[neighbour];
      const float age = static_cast<float>(age_us(now, other.stamp)) / (2 * decay_us_);
      if (age < 1) sum += other.events * (1 - age);
    });
    return sum;
  }

  // Forgets the cell and its neighbours: their events have found a cluster.
  void forget(std::size_t cell) noexcept {
    cells_[cell].events = 0;
    map_.for_each_neighbour(cell, [&](std::size_t neighbour) { cells_[neighbour].events = 0; });
  }

  void scrub(Stamp now, std::uint64_t elapsed_us) noexcept {
    scrubber_.advance(elapsed_us, [&](std::size_t first, std::size_t count) {
      fast::scrub(cells_.data() + first, count, now,
                  [](Cell& cell) -> Stamp& { return cell.stamp; });
    });
  }

 private:
  struct Cell {
    Stamp stamp;
    float events;
  };

  CellMap map_;
  float decay_us_;
  std::vector<Cell> cells_;
  Scrubber scrubber_;
};

}  // namespace asap::fast
