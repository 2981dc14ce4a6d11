#include "algorithms/fast/fragment.hpp"

#include <cstdint>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/merge.hpp"

namespace asap::fast {
namespace {

constexpr float kGrown_s = 0.2F;  // who was taken for one at birth has parted by then, mostly
constexpr float kMostMass = 0.2F;
constexpr float kReach = 1.25F;  // of the gate

bool touches_another_object(const Tracks& tracks, Tracks::Slot slot) noexcept {
  const Life& life = tracks.life(slot);
  for (std::uint8_t i = 0; i < tracks[slot].partners; ++i) {
    if (!are_siblings(tracks, slot, life.partners[i])) return true;
  }
  return false;
}

}  // namespace

bool may_be_fragment(const Tracks& tracks, Tracks::Slot newborn, Tracks::Slot grown, float dx,
                     float dy) noexcept {
  const Life& life = tracks.life(grown);
  return life.age_s > kGrown_s && tracks.life(newborn).mass < kMostMass * life.mass &&
         gate_value(tracks[grown], {.mean_x = 0, .mean_y = 0, .dx = dx, .dy = dy}) <=
             kReach * kReach &&
         !touches_another_object(tracks, grown);
}

}  // namespace asap::fast
