#include "algorithms/fast/split.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace asap::inline v0_1::fast {
namespace {

// The covariance of cells that are evenly filled.
void set_spread(Track& track, TrackState& state, const Part& part) noexcept {
  const float pixels = static_cast<float>(part.cells.size()) * kCell_px * kCell_px;
  track.sxx = track.syy = std::max(4.0F, pixels / 10);
  track.sxy = 0;
  state.extent_px = std::sqrt(track.sxx);
}

}  // namespace

// ---- objects that separated ----

bool extent_has_grown(const Track& track, const TrackState& state, float dense_per_px) noexcept {
  constexpr float kSmallest_px2 = 64;
  constexpr float kGrowth = 2;
  if (track.phase != Phase::kConfirmed || track.partners > 0) return false;
  const float remembered = 1e-6F * kLink_us * state.slow_rate_hz;
  if (remembered < dense_per_px * state.extent_px) return false;
  const float extent2 = state.extent_px * state.extent_px;
  return extent2 >= std::max(kSmallest_px2, kGrowth * state.average_extent2);
}

PartFinder::PartFinder(const CellMap& map) : map_(map) { cells_.reserve(owned_.size()); }

std::span<const Part> PartFinder::find(const OwnerGrid& owners, const Tracks& tracks,
                                       Tracks::Slot slot, Stamp now,
                                       std::int32_t link_us) noexcept {
  const Point mean = predicted_mean(tracks[slot], now);
  const float reach_px = std::min(48.0F, 2.5F * tracks.state(slot).extent_px + 6);
  mark(owners, tracks, slot, now, link_us, mean.x, mean.y, reach_px);
  cells_.clear();
  std::size_t found = 0;
  const auto window = static_cast<std::size_t>(window_.columns * window_.rows);
  for (std::size_t start = 0; start < window && found < kMaxParts; ++start) {
    if (owned_[start] == 0) continue;
    const std::size_t first = cells_.size();
    grow(start);
    if (cells_.size() - first < kMinPartCells) {
      cells_.resize(first);
    } else {
      parts_[found++] = part_of(first);
    }
  }
  return {parts_.data(), found};
}

// The part of the cells from `first` on, which become cells of the grid instead of the window.
Part PartFinder::part_of(std::size_t first) noexcept {
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

void PartFinder::mark(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot, Stamp now,
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

// ---- unresolved objects ----

bool looks_unresolved(const Track& track, const Contour& contour, const TrackState& state,
                      float noise_hz) noexcept {
  constexpr float kScatter_px2 = 4;        // scatter of events about one outline
  constexpr float kNoiseScatter_px2 = 60;  // scatter of noise anywhere in the gate
  constexpr float kElongation = 2.7F;      // ratio of variances; an L of equal arms has 2 to 2.6
  constexpr float kYoung_s = 0.04F;
  constexpr std::uint32_t kKnownEvents = 100;
  if (track.phase != Phase::kConfirmed || track.partners > 0 || state.near_confirmed) return false;
  if (state.starved_s > 0 || state.age_s < kYoung_s || track.events < kKnownEvents) return false;
  const float noise = noise_hz * mature_gate_area(track) / std::max(1.0F, state.slow_rate_hz);
  if (contour.variance < kScatter_px2 + kNoiseScatter_px2 * noise) return false;
  const float largest = largest_variance(track);
  return largest >= kElongation * (track.sxx + track.syy - largest);
}

HalfFinder::HalfFinder(const CellMap& map) : map_(map) {
  constexpr std::size_t kSide = 2 * kMaxHalf + 1;
  owned_cells_.reserve(kSide * kSide);
  cells_.reserve(kSide * kSide);
}

std::span<const Part> HalfFinder::find(const OwnerGrid& owners, const Tracks& tracks,
                                       Tracks::Slot slot, Stamp now) noexcept {
  gather(owners, tracks, slot, now);
  const auto [first, axis] = cut();
  const std::span<const OwnedCell> cells(owned_cells_);
  if (!has_both_edges(cells.first(first)) || !has_both_edges(cells.subspan(first))) return {};
  const Spread one = spread_of(axis, cells.first(first));
  const Spread other = spread_of(axis, cells.subspan(first));
  if (one.lies_along() && other.lies_along()) return {};
  cells_.clear();
  for (const OwnedCell& cell : owned_cells_) cells_.push_back(cell.index);
  halves_ = {part_of(0, first, one.along),
             part_of(first, owned_cells_.size() - first, other.along)};
  const Part* predicted = part_at_prediction(halves_, tracks[slot], tracks.state(slot), now);
  if (predicted != halves_.data()) std::swap(halves_[0], halves_[1]);
  return halves_;
}

void HalfFinder::gather(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot,
                        Stamp now) noexcept {
  constexpr std::int32_t kRecent_us = 20'000;
  const Point mean = predicted_mean(tracks[slot], now);
  const float reach_px = std::min(72.0F, 3 * tracks.state(slot).extent_px + 6);
  const int half = std::min(kMaxHalf, map_.cells_in(reach_px));
  const CellMap::Window window = map_.window(mean.x, mean.y, half);
  owned_cells_.clear();
  for (int r = window.top; r < window.top + window.rows; ++r) {
    for (int c = window.left; c < window.left + window.columns; ++c) {
      const auto row = static_cast<std::size_t>(r);
      const auto column = static_cast<std::size_t>(c);
      const std::size_t index = row * map_.stride() + column;
      const OwnerGrid::Cell& cell = owners[index];
      if (cell.slot != slot || cell.generation != tracks[slot].generation) continue;
      if (age_us(now, cell.stamp) > kRecent_us) continue;
      owned_cells_.push_back({map_.centre(column), map_.centre(row), index,
                              cell.on ? std::int8_t{1} : std::int8_t{-1}});
    }
  }
}

// Cuts across the long axis, through the mean. Puts the cells of the first half before the others
// and returns their number and the axis.
HalfFinder::Cut HalfFinder::cut() noexcept {
  const auto count = static_cast<float>(std::max<std::size_t>(1, owned_cells_.size()));
  float x = 0;
  float y = 0;
  for (const OwnedCell& cell : owned_cells_) {
    x += cell.x / count;
    y += cell.y / count;
  }
  float xx_yy = 0;
  float xy = 0;
  for (const OwnedCell& cell : owned_cells_) {
    const float dx = cell.x - x;
    const float dy = cell.y - y;
    xx_yy += dx * dx - dy * dy;
    xy += dx * dy;
  }
  const float half = xx_yy / 2;
  const float root = length(half, xy);
  const Point axis = half >= 0 ? Point{half + root, xy} : Point{xy, root - half};
  const auto middle = std::partition(
      owned_cells_.begin(), owned_cells_.end(),
      [&](const OwnedCell& cell) { return (cell.x - x) * axis.x + (cell.y - y) * axis.y < 0; });
  return {static_cast<std::size_t>(middle - owned_cells_.begin()), axis};
}

bool HalfFinder::has_both_edges(std::span<const OwnedCell> cells) const noexcept {
  constexpr float kOneSided = 0.3F;
  float sum = 0;
  for (const OwnedCell& cell : cells) sum += cell.sign;
  return cells.size() >= kMinPartCells &&
         std::abs(sum) <= kOneSided * static_cast<float>(cells.size());
}

HalfFinder::Spread HalfFinder::spread_of(Point axis, std::span<const OwnedCell> cells) noexcept {
  const auto count = static_cast<float>(cells.size());
  float along = 0;
  float across = 0;
  float along2 = 0;
  float across2 = 0;
  for (const OwnedCell& cell : cells) {
    const float u = cell.x * axis.x + cell.y * axis.y;
    const float v = cell.x * axis.y - cell.y * axis.x;
    along += u / count;
    across += v / count;
    along2 += u * u / count;
    across2 += v * v / count;
  }
  const float scale = length(axis.x, axis.y);
  return {std::sqrt(std::max(0.0F, along2 - along * along)) / scale,
          std::sqrt(std::max(0.0F, across2 - across * across)) / scale};
}

Part HalfFinder::part_of(std::size_t first, std::size_t count, float spread_px) const noexcept {
  Part part{0, 0, std::span<const std::size_t>(cells_).subspan(first, count), spread_px};
  for (const OwnedCell& cell : std::span<const OwnedCell>(owned_cells_).subspan(first, count)) {
    part.x += cell.x / static_cast<float>(count);
    part.y += cell.y / static_cast<float>(count);
  }
  return part;
}

bool have_parted(TrackState& state, std::span<const Part> halves, float birth_radius_px) noexcept {
  constexpr float kMoved_px = 3;
  constexpr float kMovedShare = 0.2F;  // the ends of a rotating long object move less
  constexpr float kApart = 2;          // sums of spreads; 1.7 for one that is evenly filled
  constexpr float kWindow_s = 0.3F;
  if (halves.empty()) {
    state.unresolved_s = 0;
    return false;
  }
  const HalvesOffset now{halves[1].x - halves[0].x, halves[1].y - halves[0].y, state.age_s};
  const HalvesOffset first = state.halves;
  const float distance = length(now.dx, now.dy);
  const float before = length(first.dx, first.dy);
  if (before == 0 || now.at_s - first.at_s > kWindow_s) {
    state.halves = now;
    return false;
  }
  const float spreads_px = halves[0].spread_px + halves[1].spread_px;
  if (distance > 2 * birth_radius_px && distance < kApart * spreads_px) return false;
  if (std::abs(distance - before) < std::max(kMoved_px, kMovedShare * before)) return false;
  state.unresolved_s = 0;
  state.halves = {};
  return true;
}

// ---- splitting ----

float share_of(const Part& part, std::span<const Part> parts) noexcept {
  std::size_t cells = 0;
  for (const Part& one : parts) cells += one.cells.size();
  return static_cast<float>(part.cells.size()) / static_cast<float>(cells);
}

const Part* part_at_prediction(std::span<const Part> parts, const Track& track,
                               const TrackState& state, Stamp now) noexcept {
  if (parts.size() < 2) return nullptr;
  const float ahead_s = age_s(now, state.kalman.stamp);
  const Part predicted{
      state.kalman.x + track.vx * ahead_s, state.kalman.y + track.vy * ahead_s, {}};
  return &*std::min_element(parts.begin(), parts.end(), [&](const auto& a, const auto& b) {
    return a.distance(predicted) < b.distance(predicted);
  });
}

void restart_at_part(Tracks& tracks, Tracks::Slot slot, const Part& part, float share,
                     Stamp now) noexcept {
  constexpr std::uint32_t kEvents = 30;
  constexpr float kPositionVariance_px2 = 9;
  Track& track = tracks[slot];
  TrackState& state = tracks.state(slot);
  // The next tick still counts the events since the last one.
  const std::uint32_t fresh = track.events - state.events;
  track.events = std::min(track.events, kEvents);
  state.events = track.events - fresh;
  if (fresh > 0) state.last_event = track.stamp;
  track.x = part.x;
  track.y = part.y;
  track.stamp = now;
  set_spread(track, state, part);
  state.mass *= share;
  state.fast_rate_hz *= share;
  state.slow_rate_hz *= share;
  state.kalman.x = part.x;
  state.kalman.y = part.y;
  state.kalman.stamp = now;
  state.kalman.events = track.events;
  state.kalman.pxx += kPositionVariance_px2;
  tracks.contour(slot).forget_radius();
  state.centre_variance = kInitialCentreVariance;
  tracks.contour(slot).sides = {};
}

void begin_at_part(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child, const Part& part,
                   float share) noexcept {
  constexpr std::uint32_t kEvents = 10;
  constexpr float kEvidence = 4;
  Track& track = tracks[child];
  TrackState& state = tracks.state(child);
  track.vx = tracks[parent].vx;
  track.vy = tracks[parent].vy;
  track.events = state.events = state.kalman.events = kEvents;
  state.mass = share * tracks.state(parent).mass;
  state.evidence = kEvidence;
  set_spread(track, state, part);
}

void confirm_child(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child, float share,
                   const GateRule& gate) noexcept {
  // Small, so that neither looks unresolved before it has an outline.
  constexpr float kInitialVariance_px2 = 2;
  TrackState& state = tracks.state(child);
  TrackState& past = tracks.state(parent);
  tracks[child].phase = Phase::kConfirmed;
  state.age_s = past.age_s;
  state.confirmed_s = past.confirmed_s;
  state.fast_rate_hz = past.fast_rate_hz * share / (1 - share);
  state.slow_rate_hz = past.slow_rate_hz * share / (1 - share);
  state.average_vx = past.average_vx;
  state.average_vy = past.average_vy;
  // The velocity was that of both.
  past.kalman.pvv = std::max(past.kalman.pvv, state.kalman.pvv);
  for (const Tracks::Slot slot : {parent, child}) {
    tracks.contour(slot).variance = kInitialVariance_px2;
    tracks.state(slot).average_extent2 = largest_variance(tracks[slot]);
    shape_gate(tracks[slot], gate, kGateScale, tracks.state(slot).young_radius_px,
               tracks.state(slot).average_extent2, true, 0);
  }
}

}  // namespace asap::inline v0_1::fast
