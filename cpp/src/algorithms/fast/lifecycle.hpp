// Track life cycle. Birth: events that no track takes are counted per cell, and a tentative track
// begins where they are more than noise explains. Confirmation: once its own events are more than
// noise explains, for long enough. A confirmed track whose object stops or is occluded is starved,
// then not listed, then coasts with its id and gate, and is deleted at last. One thread;
// BirthGrid::count() per event, the rest at the tick. O(1) per track; allocates in the constructor
// of BirthGrid only.
// Source: own design; the evidence is a sequential likelihood-ratio test (Wald 1945).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/association.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

// ---- birth ----

// Counts of unassociated events per cell, with exponential decay.
class BirthGrid {
 public:
  explicit BirthGrid(const CellMap& map) : map_(map), cells_(map.size()), scrubber_(map.size()) {}

  void clear(Stamp now) noexcept {
    std::fill(cells_.begin(), cells_.end(), Cell{long_before(now), 0.0F});
  }

  // Counts one event. Returns the count of its cell plus those of the neighbours, whose decay is
  // linear here and reaches zero after twice the time constant.
  float count(std::size_t cell, Stamp now) noexcept {
    Cell& own = cells_[cell];
    own.events = own.events * decay(static_cast<float>(age_us(now, own.stamp)) / kSeed_us) + 1;
    own.stamp = now;
    float sum = own.events;
    map_.for_each_neighbour(cell, [&](std::size_t neighbour) {
      const Cell& other = cells_[neighbour];
      const float age = static_cast<float>(age_us(now, other.stamp)) / (2 * kSeed_us);
      if (age < 1) sum += other.events * (1 - age);
    });
    return sum;
  }

  // Clears the cell and its neighbours, where a track has begun.
  void forget(std::size_t cell) noexcept {
    cells_[cell].events = 0;
    map_.for_each_neighbour(cell, [&](std::size_t neighbour) { cells_[neighbour].events = 0; });
  }

  void scrub(Stamp now, std::uint64_t elapsed_us) noexcept {
    scrubber_.scrub(cells_.data(), now, elapsed_us,
                    [](Cell& cell) -> Stamp& { return cell.stamp; });
  }

 private:
  struct Cell {
    Stamp stamp;
    float events;
  };

  CellMap map_;
  std::vector<Cell> cells_;
  Scrubber scrubber_;
};

// ---- confirmation, starvation, coasting, deletion ----

struct LifecycleRule {
  float confirm_events = 0;  // mass from which a track is confirmed; fewer with gamma
  float die_events = 0;      // mass below which it coasts; fewer with gamma
  float birth_rate_hz = 0;   // least event rate of an object, times gamma
  float coast_s;             // time from too little mass to deletion
};

// What one tick has in common for all tracks.
struct Tick {
  Tick(Stamp now, float dt_s, float noise_hz) noexcept;

  Stamp now;
  float dt_s;
  float noise_hz;  // per pixel, of events that reach the tracks
  float mass_decay;
  float fast_decay;
  float slow_decay;
  float motion_decay;
  float extent_decay;
};

enum class Assessment { kKeep, kConfirm, kDelete };

// Counts the new events and decides. After kConfirm the caller sets phase and id.
Assessment assess(Track& track, TrackState& state, const Tick& tick,
                  const LifecycleRule& rule) noexcept;

// Sets the gate by phase, age, size and rates. `widest_px`: of a young track's circle.
void update_gate(Track& track, TrackState& state, const GateRule& gate, float widest_px) noexcept;

// Records position and average velocity of a track that is not starved.
void record_motion(const Track& track, TrackState& state, const Tick& tick) noexcept;

// Puts an unlisted track back to where it was last seen: if the object stopped, the track's own
// gate finds it there.
void return_to_last_seen(Track& track, TrackState& state) noexcept;

// Updates the average extent. Only for a track that is not in contact.
void record_extent(TrackState& state, float extent2, const Tick& tick) noexcept;

// Whether the track has been starved for long enough: its object must have stopped or be hidden.
inline constexpr float kStarved_s = 0.01F;
inline bool is_starved(const TrackState& state) noexcept { return state.starved_s > kStarved_s; }

inline bool is_listed(const Track& track, const TrackState& state) noexcept {
  return track.phase == Phase::kConfirmed && state.starved_s < kHide_s;
}

struct Frame {
  std::uint32_t width;  // px
  std::uint32_t height;
};

// Whether the predicted mean lies more than 2 px beyond the edges of the frame, or is not a number.
bool has_left(const Track& track, Stamp now, const Frame& frame) noexcept;

}  // namespace asap::inline v0_1::fast
