#include "algorithms/fast/siblings.hpp"

#include <limits>

namespace asap::fast {
namespace {

bool is_sibling(const Tracks& tracks, Tracks::Slot of, Tracks::Slot other) noexcept {
  const TrackState& state = tracks.state(of);
  return state.sibling == other && state.sibling_generation == tracks[other].generation;
}

}  // namespace

bool are_siblings(const Tracks& tracks, Tracks::Slot a, Tracks::Slot b) noexcept {
  return is_sibling(tracks, a, b) || is_sibling(tracks, b, a);
}

void find_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now, const PairRule& rule) noexcept {
  TrackState& state = tracks.state(slot);
  const Point here = predicted_mean(tracks[slot], now);
  float nearest = std::numeric_limits<float>::infinity();
  for (const Tracks::Slot other : tracks.active()) {
    if (other == slot || !tracks[other].has_id()) continue;
    const Point there = predicted_mean(tracks[other], now);
    const float distance = length(here.x - there.x, here.y - there.y);
    const float reach = merge_distance(state.extent_px + tracks.state(other).extent_px, rule);
    if (distance > reach || distance >= nearest) continue;
    nearest = distance;
    state.sibling = other;
    state.sibling_generation = tracks[other].generation;
  }
}

void forget_far_sibling(Tracks& tracks, Tracks::Slot slot, Stamp now,
                        const PairRule& rule) noexcept {
  TrackState& state = tracks.state(slot);
  if (state.sibling == kNoSlot) return;
  if (is_sibling(tracks, slot, state.sibling)) {
    constexpr float kMargin_px = 4;
    const Point here = predicted_mean(tracks[slot], now);
    const Point there = predicted_mean(tracks[state.sibling], now);
    const float extents = state.extent_px + tracks.state(state.sibling).extent_px;
    if (length(there.x - here.x, there.y - here.y) <= merge_distance(extents, rule) + kMargin_px)
      return;
  }
  state.sibling = kNoSlot;
}

void inherit_siblings(Tracks& tracks, Tracks::Slot survivor, Tracks::Slot other) noexcept {
  for (const Tracks::Slot slot : tracks.active()) {
    if (!is_sibling(tracks, slot, other)) continue;
    tracks.state(slot).sibling = slot == survivor ? kNoSlot : survivor;
    tracks.state(slot).sibling_generation = tracks[survivor].generation;
  }
}

}  // namespace asap::fast
