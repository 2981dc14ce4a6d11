// Engine: the fast cluster tracker. An event without support is noise. Any other event goes to the
// owner of its cell if the owner's gate accepts it, as for nine events in ten; else to the nearest
// track whose gate accepts it; else it is unassociated, and where such events are dense a track
// begins. Everything slow waits for a tick of a millisecond: the tracks at every other tick, noise
// and pairs at the ticks between. One thread. O(1) per event, whatever the number of tracks; a tick
// is O(n^2) of cheap steps in n tracks. Allocates in the constructor only. Results do not depend on
// how the stream is cut into calls.
// Source: own design, not a published algorithm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/association.hpp"
#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/noise.hpp"
#include "algorithms/fast/objects.hpp"
#include "algorithms/fast/pairs.hpp"
#include "algorithms/fast/settings.hpp"
#include "algorithms/fast/split.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"
#include "algorithms/fast/update.hpp"
#include "algorithms/smooth_gamma.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/core/event.hpp"
#include "core/event_clock.hpp"

namespace asap::inline v0_1::fast {

class Engine {
 public:
  static constexpr std::int32_t kNoId = -1;

  struct Counters {
    std::uint64_t rejected = 0;     // outside the frame
    std::uint64_t unsupported = 0;  // without support
    std::uint64_t refused = 0;      // births while the table was full
  };

  // Precondition: the configuration is checked.
  explicit Engine(const ClusterTrackerConfig& config);

  // labels[i]: the id of the cluster that takes events[i], or kNoId; null: not wanted.
  void process(EventSpan events, std::int32_t* labels) noexcept;

  // Advances the time to t_us without events: tracks are starved, coast and are deleted.
  void advance_to(std::int64_t t_us) noexcept;

  // Sets `clusters` to the listed clusters at t_us, sorted by id, if no event comes until then. A
  // t_us of the past counts as the latest time. Allocates only where `clusters` must grow.
  void read(std::int64_t t_us, std::vector<Cluster>& clusters) const;

  // The same with the shown objects.
  void read(std::int64_t t_us, std::vector<TrackedObject>& objects) const;

  // Sets `clusters` to those listed now that are parts of this object, the heaviest first; empty:
  // no such object is shown.
  void read_parts(std::int64_t object, std::vector<Cluster>& clusters) const;

  // The id of the shown object whose part the cluster with this id is, or kNoId.
  std::int32_t object_of(std::int32_t cluster) const noexcept;

  // The latest timestamp.
  std::int64_t latest_us() const noexcept { return clock_.latest_us(); }

  void set_gamma(double gamma, bool filtered_upstream) noexcept;
  void reset() noexcept;

  const Counters& counters() const noexcept { return counters_; }

 private:
  using Slot = Tracks::Slot;

  // ---- output ----
  EventClock clock_at(std::int64_t t_us) const noexcept;
  template <class Chosen, class Visit>
  void for_each_listed(const EventClock& clock, Chosen&& chosen, Visit&& visit) const;
  ObjectSum sum_of(std::size_t object, const EventClock& clock) const;

  // ---- per event ----
  void advance(std::int64_t t_us) noexcept;
  std::int32_t process(const Event& event) noexcept;
  std::int32_t assign(Slot slot, OwnerGrid::Cell& cell, const Event& event, Stamp now) noexcept;
  std::int32_t associate(const Event& event, std::size_t cell, Stamp now, bool may_begin) noexcept;
  Slot nearest_track(const Event& event, std::size_t cell, Stamp now) noexcept;
  Slot try_birth(const Event& event, std::size_t cell, Stamp now) noexcept;
  Slot begin_track(float x, float y) noexcept;

  // ---- per tick ----
  void forget() noexcept;
  void start() noexcept;
  void tick_if_due() noexcept;
  void tick() noexcept;
  void update_tracks() noexcept;
  bool update_track(Slot slot, const Tick& tick) noexcept;
  void confirm(Slot slot) noexcept;
  void update_objects() noexcept;
  void update_pairs_and_noise() noexcept;
  void measure_noise() noexcept;
  void merge_pairs(float dt_s) noexcept;
  void split_next() noexcept;
  void split(Slot slot) noexcept;
  void halve(Slot slot) noexcept;
  Slot begin_part(Slot parent, const Part& part, float share) noexcept;
  void remove(Slot slot) noexcept;

  ClusterTrackerConfig config_;
  Settings settings_;
  SmoothGamma gamma_;
  bool filtered_upstream_ = false;
  Frame frame_;
  CellMap map_;
  EventClock clock_;
  SupportMap support_;
  OwnerGrid owners_;
  BirthGrid births_;
  NoiseTiles noise_;
  CoarseIndex coarse_;
  Tracks tracks_;
  Pairs pairs_;
  PartFinder parts_;
  HalfFinder halves_;
  Objects objects_;
  std::size_t next_split_ = 0;
  DirectionTable directions_;
  Counters counters_;
  std::uint64_t due_us_ = 0;       // the next tick ...
  std::int64_t due_stamp_us_ = 0;  // ... and the timestamp that makes it due
  bool tracks_are_due_ = true;     // the next tick updates tracks, else noise and pairs
  std::uint64_t started_us_ = 0;
  bool has_confirmed_ = false;  // a track, since the objects were updated
  std::uint64_t objects_us_ = 0;
  std::uint64_t tracks_us_ = 0;  // when each of the two was updated
  std::uint64_t pairs_us_ = 0;
  std::uint64_t noise_us_ = 0;
  std::int32_t support_window_us_ = 0;  // grows as far as the noise allows
  float noise_hz_ = 0;                  // per pixel, of the noise that reaches the tracks
  float widest_radius_px_ = 0;          // widest circle of a young track's gate
  float birth_threshold_ = 0;           // recent unassociated events around a cell
  std::int32_t next_id_ = 0;
};

}  // namespace asap::inline v0_1::fast
