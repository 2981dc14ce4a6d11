// Objects: one id per thing, that of the track that founded it, over the tracks of the engine. A
// thing is several tracks where parts of it fire apart, and a patch of noise may be a track, so the
// tracks are grouped every 5 ms. LOST: a new track continues the object that must have reappeared
// there, else it begins one. ADOPT: what begins at a large object is a part of it. LEAVE: parts
// that stay apart from the others become an object of their own. JOIN: objects that touch and begin
// together, or have one edge each, are one until the box around both changes.
// NOISE: an object is shown once its tracks fire more than the noise around them explains, unless
// it flickers. QUIET: an object without events is not shown. The layer reads the engine and changes
// nothing in it. One thread, at the tick. O(n^2) of cheap steps in n tracks; allocates in the
// constructor only. Source: own design.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/noise.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"

namespace asap::inline v0_1::fast {

// What the parts of an object add up to. Position and velocity are those of the heaviest part: the
// centre of the box jumps with every part that comes or goes.
struct ObjectSum {
  std::size_t parts = 0;
  Tracks::Slot lead = Tracks::kNone;  // the heaviest part
  float lead_mass = 0;
  float x = 0;  // px
  float y = 0;
  float vx = 0;  // px/s
  float vy = 0;
  Box box{};
  float mass = 0;
  float rate_hz = 0;
  std::int32_t quiet_us = std::numeric_limits<std::int32_t>::max();  // since the newest event

  void add(Tracks::Slot slot, const Track& track, const TrackState& state, const Contour& contour,
           Stamp now) noexcept;

  bool is_quiet() const noexcept;
};

class Objects {
 public:
  using Slot = Tracks::Slot;
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  explicit Objects(std::size_t slots);

  // Groups the listed tracks, if 5 ms have passed since the last time. `next_id`: of the tracks; an
  // object takes it whose tracks have all given theirs to others.
  void update(const Tracks& tracks, const NoiseTiles& noise, std::uint64_t now_us,
              std::int32_t& next_id) noexcept;

  void clear() noexcept;

  // The object whose part a track is, as an index below size(), or kNone.
  std::size_t object_of(Slot slot, const Track& track) const noexcept;

  std::size_t size() const noexcept { return objects_.size(); }
  bool is_shown(std::size_t object) const noexcept {
    const Object& one = objects_[object];
    return one.id >= 0 && !one.is_noise && !one.bond.joined;
  }
  std::int64_t id(std::size_t object) const noexcept { return objects_[object].id; }
  std::uint64_t born_us(std::size_t object) const noexcept { return objects_[object].born_us; }

 private:
  struct Part {
    std::uint16_t generation = 0;  // the track's
    std::size_t object = kNone;
    float apart_s = 0;  // time for which it has not touched the heaviest component
    bool has_founded = false;

    void move_to(std::size_t other) noexcept {
      object = other;
      apart_s = 0;
    }
  };

  // Where its heaviest part was while it had enough events, and where it went.
  struct Way {
    std::uint64_t at_us = 0;
    Point place{};
    Point velocity{};  // px/s, average
    Point half{};      // px, half the box
  };

  // An older object that it touches or faces.
  struct Bond {
    std::size_t other = kNone;
    float width = 0;  // px, of the box around both
    float height = 0;
    float edges_s = 0;    // time for which each had the edge alone that the other lacks
    float apart_s = 0;    // once joined: time for which they have not
    bool joined = false;  // it is a part of the other
  };

  struct Object {
    std::int64_t id = -1;     // none: free
    std::uint64_t order = 0;  // number of its beginning
    std::uint64_t born_us = 0;
    std::uint64_t seen_us = 0;  // when it had parts last
    std::uint64_t back_us = 0;  // when a lost one's own track had events again
    bool has_left = false;      // another object, whose part it was
    bool is_noise = true;
    float lone_hz = 0;  // noise in its gates that is more than elsewhere
    ObjectSum sum{};
    Way way{};
    Bond bond{};
  };

  void list(const Tracks& tracks) noexcept;
  void add_up(const Tracks& tracks) noexcept;
  bool is_just_back(const Object& object) const noexcept;
  void note_ways(const Tracks& tracks) noexcept;
  void place_new(const Tracks& tracks) noexcept;
  std::size_t find_lost(const Point& place) const noexcept;
  std::size_t begin(std::int64_t id) noexcept;
  std::int64_t id_of(std::span<const Slot> founders, const Tracks& tracks) noexcept;
  void forget(std::size_t object) noexcept;
  void forget_old() noexcept;
  void adopt(const Tracks& tracks) noexcept;
  template <class Wanted>
  std::size_t find_touched(const Tracks& tracks, std::size_t object, Wanted wanted) const noexcept;
  std::size_t find_parent(const Tracks& tracks, std::size_t child) const noexcept;
  bool may_adopt(const Object& object) const noexcept;
  void leave(const Tracks& tracks, float dt_s) noexcept;
  bool divide(const Tracks& tracks, std::size_t object, float dt_s) noexcept;
  std::size_t heaviest_component(const Tracks& tracks) noexcept;
  std::size_t grow_component(const Tracks& tracks, std::size_t first) noexcept;
  void join(const Tracks& tracks, float dt_s) noexcept;
  bool began_together(const Object& younger, const Object& older) const noexcept;
  void find_bond(const Tracks& tracks, std::size_t object) noexcept;
  bool face(const Tracks& tracks, const Object& one, const Object& other) const noexcept;
  bool keeps_bond(const Object& object) const noexcept;
  void judge(const Tracks& tracks, const NoiseTiles& noise) noexcept;

  std::vector<Part> parts_;      // by slot
  std::vector<Object> objects_;  // to twice the slots: one without parts can be forgotten then
  std::vector<Slot> listed_;
  std::vector<Slot> component_;  // the parts of one object, component by component
  std::uint64_t now_us_ = 0;
  std::uint64_t begun_ = 0;
  std::int32_t* next_id_ = nullptr;  // during update()
};

}  // namespace asap::inline v0_1::fast
