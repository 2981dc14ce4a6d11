#include "algorithms/fast/split.hpp"

#include <algorithm>
#include <cmath>

namespace asap::fast {
namespace {

// As of cells that are evenly filled.
void set_spread(Track& track, Life& life, const PartFinder::Part& part, float cell_px) noexcept {
  const float pixels = static_cast<float>(part.cells.size()) * cell_px * cell_px;
  track.sxx = track.syy = std::max(4.0F, pixels / 10);
  track.sxy = 0;
  life.extent_px = std::sqrt(track.sxx);
}

}  // namespace

PartFinder::PartFinder(const CellMap& map) : map_(map) { cells_.reserve(owned_.size()); }

std::span<const PartFinder::Part> PartFinder::find(OwnerGrid& owners, const Tracks& tracks,
                                                   Tracks::Slot slot, Stamp now,
                                                   std::int32_t link_us) noexcept {
  const Sight here = sight_of(tracks[slot], now, 0, 0);
  const float reach_px = std::min(48.0F, 2.5F * tracks.life(slot).extent_px + 6);
  mark(owners, tracks, slot, now, link_us, here.mean_x, here.mean_y, reach_px);
  cells_.clear();
  std::size_t found = 0;
  const auto window = static_cast<std::size_t>(window_.columns * window_.rows);
  for (std::size_t start = 0; start < window && found < kMaxParts; ++start) {
    if (owned_[start] == 0) continue;
    const std::size_t first = cells_.size();
    grow(start);
    if (cells_.size() - first < kMinCells) {
      cells_.resize(first);
    } else {
      parts_[found++] = part_of(first);
    }
  }
  return {parts_.data(), found};
}

// Of the cells from `first` on, which it turns from cells of the window into cells of the grid.
PartFinder::Part PartFinder::part_of(std::size_t first) noexcept {
  const auto side = static_cast<std::size_t>(window_.columns);
  Part part{0, 0, std::span<const std::size_t>(cells_).subspan(first)};
  for (std::size_t k = first; k < cells_.size(); ++k) {
    const std::size_t row = cells_[k] / side + static_cast<std::size_t>(window_.top);
    const std::size_t column = cells_[k] % side + static_cast<std::size_t>(window_.left);
    cells_[k] = row * map_.stride() + column;
    part.x += map_.centre(column);
    part.y += map_.centre(row);
  }
  part.x /= static_cast<float>(part.cells.size());
  part.y /= static_cast<float>(part.cells.size());
  return part;
}

void PartFinder::mark(OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot, Stamp now,
                      std::int32_t link_us, float x, float y, float reach_px) noexcept {
  const auto half = std::min(kMaxHalf, map_.cells_in(reach_px));
  window_ = map_.window(x, y, half);
  std::uint8_t* owned = owned_.data();
  for (int r = window_.top; r < window_.top + window_.rows; ++r) {
    const std::size_t line = static_cast<std::size_t>(r) * map_.stride();
    for (int c = window_.left; c < window_.left + window_.columns; ++c) {
      const OwnerGrid::Cell& cell = owners[line + static_cast<std::size_t>(c)];
      *owned++ = cell.slot == slot && cell.generation == tracks[slot].generation &&
                 age_us(now, cell.stamp) <= link_us;
    }
  }
}

// Appends all cells of the window that are connected with `start`.
void PartFinder::grow(std::size_t start) noexcept {
  std::size_t next = cells_.size();
  cells_.push_back(start);
  owned_[start] = 0;
  const auto side = static_cast<std::size_t>(window_.columns);
  for (; next < cells_.size(); ++next) {
    const int row = static_cast<int>(cells_[next] / side);
    const int column = static_cast<int>(cells_[next] % side);
    const int last_row = std::min(window_.rows - 1, row + kReach_cells);
    const int last_column = std::min(window_.columns - 1, column + kReach_cells);
    for (int r = std::max(0, row - kReach_cells); r <= last_row; ++r) {
      for (int c = std::max(0, column - kReach_cells); c <= last_column; ++c) {
        const auto neighbour = static_cast<std::size_t>(r) * side + static_cast<std::size_t>(c);
        if (owned_[neighbour] == 0) continue;
        owned_[neighbour] = 0;
        cells_.push_back(neighbour);
      }
    }
  }
}

float share_of(const PartFinder::Part& part, std::span<const PartFinder::Part> parts) noexcept {
  std::size_t cells = 0;
  for (const PartFinder::Part& one : parts) cells += one.cells.size();
  return static_cast<float>(part.cells.size()) / static_cast<float>(cells);
}

bool has_grown(const Track& track, const Life& life) noexcept {
  constexpr float kSmallest_px2 = 64;
  constexpr float kGrowth = 2;
  const float extent2 = life.extent_px * life.extent_px;
  return track.phase == Phase::kConfirmed && track.partners == 0 &&
         extent2 >= std::max(kSmallest_px2, kGrowth * life.usual_extent2);
}

const PartFinder::Part* home_of(std::span<const PartFinder::Part> parts, const Track& track,
                                const Life& life, Stamp now) noexcept {
  if (parts.size() < 2) return nullptr;
  const float ahead_s = 1e-6F * static_cast<float>(age_us(now, life.kalman.stamp));
  const PartFinder::Part predicted{
      life.kalman.x + track.vx * ahead_s, life.kalman.y + track.vy * ahead_s, {}};
  return &*std::min_element(parts.begin(), parts.end(), [&](const auto& a, const auto& b) {
    return a.distance(predicted) < b.distance(predicted);
  });
}

void keep_part(Tracks& tracks, Tracks::Slot slot, const PartFinder::Part& part, float share,
               float cell_px, Stamp now) noexcept {
  constexpr std::uint32_t kEvents = 30;
  constexpr float kDoubt_px2 = 9;
  Track& track = tracks[slot];
  Life& life = tracks.life(slot);
  // What is new since the last tick stays new: the tick counts it.
  const std::uint32_t fresh = track.events - life.events;
  track.events = std::min(track.events, kEvents);
  life.events = track.events - fresh;
  if (fresh > 0) life.last_event = track.stamp;
  track.x = part.x;
  track.y = part.y;
  track.stamp = now;
  set_spread(track, life, part, cell_px);
  life.mass *= share;
  life.fast_rate_hz *= share;
  life.slow_rate_hz *= share;
  life.kalman.x = part.x;
  life.kalman.y = part.y;
  life.kalman.stamp = now;
  life.kalman.events = track.events;
  life.kalman.pxx += kDoubt_px2;
  tracks.contour(slot).forget_radius();
}

void inherit_part(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child,
                  const PartFinder::Part& part, float share, float cell_px) noexcept {
  constexpr std::uint32_t kEvents = 10;
  constexpr float kEvidence = 4;
  Track& track = tracks[child];
  Life& life = tracks.life(child);
  track.vx = tracks[parent].vx;
  track.vy = tracks[parent].vy;
  track.events = life.events = life.kalman.events = kEvents;
  life.mass = share * tracks.life(parent).mass;
  life.evidence = kEvidence;
  set_spread(track, life, part, cell_px);
}

}  // namespace asap::fast
