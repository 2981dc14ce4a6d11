#include "study/owner_cell_merge.hpp"

#include "algorithms/fast/merge.hpp"

namespace asap {
namespace {

constexpr float kReach2 = 0.8F;  // in R^2

bool may_be_one(const fast::Track& a, const fast::Track& b) noexcept {
  if (!a.has_id() || !b.has_id()) return true;
  const float speeds = fast::length(a.vx, a.vy) + fast::length(b.vx, b.vy);
  return fast::length(a.vx - b.vx, a.vy - b.vy) < 0.5F * speeds + 25;
}

}  // namespace

OwnerCellMerge::OwnerCellMerge(const fast::CellMap& map, std::size_t slots, int radius_px)
    : cells_(map.size()),
      reach2_(kReach2 * static_cast<float>(radius_px * radius_px)),
      partners_(slots) {}

OwnerCellMerge::Slot OwnerCellMerge::join_tentative(fast::Tracks& tracks,
                                                    fast::OwnerGrid& owners) const noexcept {
  for (const Slot slot : tracks.active()) {
    if (tracks[slot].has_id()) continue;
    const Slot other = nearest_to(tracks, slot);
    if (other != fast::Tracks::kNone) return join(tracks, owners, slot, other);
  }
  return fast::Tracks::kNone;
}

void OwnerCellMerge::hold(const fast::Tracks& tracks) noexcept {
  for (const Slot slot : tracks.active()) {
    const Slot other = tracks[slot].has_id() ? nearest_to(tracks, slot) : fast::Tracks::kNone;
    Partner& partner = partners_[slot];
    if (other == fast::Tracks::kNone) {
      partner = {};
      continue;
    }
    const std::uint16_t generation = tracks[other].generation;
    const bool same = partner.slot == other && partner.generation == generation;
    partner = {other, generation, same ? partner.ticks + 1 : 1};
  }
}

OwnerCellMerge::Slot OwnerCellMerge::join_confirmed(fast::Tracks& tracks,
                                                    fast::OwnerGrid& owners) const noexcept {
  for (const Slot slot : tracks.active()) {
    const Partner& partner = partners_[slot];
    if (partner.ticks < kTicks || partner.generation != tracks[partner.slot].generation) continue;
    return join(tracks, owners, slot, partner.slot);
  }
  return fast::Tracks::kNone;
}

// Within reach; of two confirmed ones, the nearest that moves alike.
OwnerCellMerge::Slot OwnerCellMerge::nearest_to(const fast::Tracks& tracks,
                                                Slot slot) const noexcept {
  const fast::Track& track = tracks[slot];
  Slot best = fast::Tracks::kNone;
  float least = reach2_;
  for (const Slot other : tracks.active()) {
    if (other == slot) continue;
    const float dx = tracks[other].x - track.x;
    const float dy = tracks[other].y - track.y;
    const float d2 = dx * dx + dy * dy;
    if (d2 > least || !may_be_one(track, tracks[other])) continue;
    least = d2;
    best = other;
  }
  return best;
}

OwnerCellMerge::Slot OwnerCellMerge::join(fast::Tracks& tracks, fast::OwnerGrid& owners, Slot a,
                                          Slot b) const noexcept {
  const Slot survivor = fast::survivor_of(tracks, a, b);
  const Slot gone = survivor == a ? b : a;
  fast::Track& track = tracks[survivor];
  const fast::Track& other = tracks[gone];
  float& mass = tracks.state(survivor).mass;
  const float w = tracks.state(gone).mass / (tracks.state(gone).mass + mass);
  const float fx = other.x - track.x;
  const float fy = other.y - track.y;
  track.sxx = (1 - w) * track.sxx + w * other.sxx + w * (1 - w) * fx * fx;
  track.sxy = (1 - w) * track.sxy + w * other.sxy + w * (1 - w) * fx * fy;
  track.syy = (1 - w) * track.syy + w * other.syy + w * (1 - w) * fy * fy;
  track.x += w * fx;
  track.y += w * fy;
  mass += tracks.state(gone).mass;
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    fast::OwnerGrid::Cell& owner = owners[cell];
    if (owner.slot != gone || owner.generation != other.generation) continue;
    owner.slot = static_cast<std::uint8_t>(survivor);
    owner.generation = track.generation;
  }
  return gone;
}

}  // namespace asap
