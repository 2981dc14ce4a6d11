#include "algorithms/fast/halves.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace asap::fast {

bool looks_double(const Track& track, const Contour& contour, const Life& life, float noise_hz,
                  const GateRule& gate) noexcept {
  constexpr float kScatter_px2 = 4;
  constexpr float kNoiseScatter_px2 = 60;  // of noise events, anywhere in the gate
  constexpr float kTextured = 0.4F;        // weight of the plain mean: no outline to speak of
  constexpr float kElongation = 1.8F;      // of variances
  constexpr float kYoung_s = 0.04F;
  constexpr std::uint32_t kKnownEvents = 100;
  if (track.phase != Phase::kConfirmed || track.partners > 0 || life.near_confirmed) return false;
  if (life.starved_s > 0 || life.age_s < kYoung_s || track.events < kKnownEvents) return false;
  if (contour.variance < kScatter_px2 || track.mean_weight > kTextured) return false;
  const float noise = noise_hz * gate_area(track, gate, true) / std::max(1.0F, life.slow_rate_hz);
  if (contour.variance < kScatter_px2 + kNoiseScatter_px2 * noise) return false;
  const float largest = largest_variance(track);
  return largest >= kElongation * (track.sxx + track.syy - largest);
}

HalfFinder::HalfFinder(const CellMap& map) : map_(map) {
  constexpr std::size_t kSide = 2 * kMaxHalf + 1;
  places_.reserve(kSide * kSide);
  cells_.reserve(kSide * kSide);
}

std::span<const HalfFinder::Part> HalfFinder::find(const OwnerGrid& owners, const Tracks& tracks,
                                                   Tracks::Slot slot, Stamp now) noexcept {
  constexpr float kApart_px = 8;
  gather(owners, tracks, slot, now);
  const std::size_t first = cut();
  const std::span<const Place> places(places_);
  if (!is_whole(places.first(first)) || !is_whole(places.subspan(first))) return {};
  cells_.clear();
  for (const Place& place : places_) cells_.push_back(place.cell);
  halves_ = {part_of(0, first), part_of(first, places_.size() - first)};
  if (halves_[0].distance(halves_[1]) < kApart_px) return {};
  const Part* home = home_of(halves_, tracks[slot], tracks.life(slot), now);
  if (home != halves_.data()) std::swap(halves_[0], halves_[1]);
  return halves_;
}

void HalfFinder::gather(const OwnerGrid& owners, const Tracks& tracks, Tracks::Slot slot,
                        Stamp now) noexcept {
  constexpr std::int32_t kRecent_us = 20'000;
  const Sight here = sight_of(tracks[slot], now, 0, 0);
  const float reach_px = std::min(72.0F, 3 * tracks.life(slot).extent_px + 6);
  const int half = std::min(kMaxHalf, map_.cells_in(reach_px));
  const CellMap::Window window = map_.window(here.mean_x, here.mean_y, half);
  places_.clear();
  for (int r = window.top; r < window.top + window.rows; ++r) {
    for (int c = window.left; c < window.left + window.columns; ++c) {
      const auto row = static_cast<std::size_t>(r);
      const auto column = static_cast<std::size_t>(c);
      const std::size_t index = row * map_.stride() + column;
      const OwnerGrid::Cell& cell = owners[index];
      if (cell.slot != slot || cell.generation != tracks[slot].generation) continue;
      if (age_us(now, cell.stamp) > kRecent_us) continue;
      places_.push_back({map_.centre(column), map_.centre(row), index, cell.sign});
    }
  }
}

// Across the long axis, through the mean: puts the places of the first half before the others and
// returns their number.
std::size_t HalfFinder::cut() noexcept {
  const auto count = static_cast<float>(std::max<std::size_t>(1, places_.size()));
  float x = 0;
  float y = 0;
  for (const Place& place : places_) {
    x += place.x / count;
    y += place.y / count;
  }
  float xx_yy = 0;
  float xy = 0;
  for (const Place& place : places_) {
    const float dx = place.x - x;
    const float dy = place.y - y;
    xx_yy += dx * dx - dy * dy;
    xy += dx * dy;
  }
  const float half = xx_yy / 2;
  const float root = length(half, xy);
  const float along_x = half >= 0 ? half + root : xy;
  const float along_y = half >= 0 ? xy : root - half;
  const auto middle = std::partition(places_.begin(), places_.end(), [&](const Place& place) {
    return (place.x - x) * along_x + (place.y - y) * along_y < 0;
  });
  return static_cast<std::size_t>(middle - places_.begin());
}

bool HalfFinder::is_whole(std::span<const Place> places) const noexcept {
  constexpr float kOneSided = 0.3F;
  float sum = 0;
  for (const Place& place : places) sum += place.sign;
  return places.size() >= PartFinder::kMinCells &&
         std::abs(sum) <= kOneSided * static_cast<float>(places.size());
}

HalfFinder::Part HalfFinder::part_of(std::size_t first, std::size_t count) const noexcept {
  Part part{0, 0, std::span<const std::size_t>(cells_).subspan(first, count)};
  for (const Place& place : std::span<const Place>(places_).subspan(first, count)) {
    part.x += place.x / static_cast<float>(count);
    part.y += place.y / static_cast<float>(count);
  }
  return part;
}

bool have_moved_apart(Life& life, std::span<const HalfFinder::Part> halves) noexcept {
  constexpr float kMoved_px = 3;
  constexpr float kMovedShare = 0.2F;  // the ends of a long object in rotation waver by less
  constexpr float kSameAxis = 0.85F;   // cosine
  constexpr float kWindow_s = 0.3F;
  if (halves.empty()) {
    life.double_s = 0;
    return false;
  }
  const HalvesSeen now{halves[1].x - halves[0].x, halves[1].y - halves[0].y, life.age_s};
  const HalvesSeen first = life.halves;
  const float distance = length(now.dx, now.dy);
  const float before = length(first.dx, first.dy);
  const float cosine = std::abs(now.dx * first.dx + now.dy * first.dy) / (distance * before);
  if (before == 0 || now.at_s - first.at_s > kWindow_s || cosine < kSameAxis) {
    life.halves = now;
    return false;
  }
  if (std::abs(distance - before) < std::max(kMoved_px, kMovedShare * before)) return false;
  life.double_s = 0;
  life.halves = {};
  return true;
}

void raise_twin(Tracks& tracks, Tracks::Slot parent, Tracks::Slot child, float share,
                const GateRule& gate) noexcept {
  constexpr float kFitting_px2 = 2;  // so that neither looks double before it is known
  Life& life = tracks.life(child);
  Life& past = tracks.life(parent);
  tracks[child].phase = Phase::kConfirmed;
  life.age_s = past.age_s;
  life.confirmed_s = past.confirmed_s;
  life.fast_rate_hz = past.fast_rate_hz * share / (1 - share);
  life.slow_rate_hz = past.slow_rate_hz * share / (1 - share);
  life.usual_vx = past.usual_vx;
  life.usual_vy = past.usual_vy;
  past.kalman.pvv = std::max(past.kalman.pvv, life.kalman.pvv);  // it was that of both
  for (const Tracks::Slot slot : {parent, child}) {
    tracks.contour(slot).variance = kFitting_px2;
    tracks.life(slot).usual_extent2 = largest_variance(tracks[slot]);
    shape_gate(tracks[slot], gate, tracks.life(slot).usual_extent2, true, 0);
  }
}

}  // namespace asap::fast
