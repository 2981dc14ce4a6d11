// Pairs: which clusters are near each other, at the tick. Two confirmed ones whose outlines nearly
// meet are contact partners; within a wider reach a pair may be two parts of one object, and each
// track keeps the nearest such one. One thread. O(n^2) of cheap steps, no allocation after
// construction.
// Source: own design.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/stamp.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::fast {

struct PairRule {
  float birth_radius_px;     // [Rb]
  float merge_reach;         // [mK]
  float merge_padding_px;    // [mPad]
  float contact_reach;       // [contactK]
  float contact_padding_px;  // [contactPad]
};

// Two tracks that may be one, `keeper` the one that remembers so: of a mixed pair the tentative
// one, else the older.
struct Candidate {
  Tracks::Slot keeper;
  Tracks::Slot other;
  float dx;  // px, from keeper to other
  float dy;
  float distance_px;
};

class Pairs {
 public:
  explicit Pairs(std::size_t slots);

  // Sets the partners, near_confirmed and sibling of all tracks, and candidates().
  void find(Tracks& tracks, Stamp now, const PairRule& rule) noexcept;

  const std::vector<Candidate>& candidates() const noexcept { return candidates_; }

 private:
  struct Place {
    float x;
    float y;
    float extent;
    Tracks::Slot slot;
    bool has_id;
  };

  void meet(Tracks& tracks, std::size_t i, std::size_t j, float dx, float dy, float distance2,
            const PairRule& rule) noexcept;

  std::vector<Place> places_;
  std::vector<Candidate> nearest_;  // per place; no slot: none
  std::vector<Candidate> candidates_;
};

// px within which two tracks may be one.
float merge_distance(float extents_px, const PairRule& rule) noexcept;

}  // namespace asap::fast
