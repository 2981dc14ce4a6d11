// Engine: the fast clusterer. An event without company is noise; else its cell's owner takes it if
// its gate does, which is true of nine events in ten; else the nearest cluster that does; else it
// is an orphan, and dense orphans are the birth of a cluster. Everything slow waits for a tick of a
// millisecond: clusters in one half of them, noise and pairs in the other.
// One thread. O(1) per event, whatever the number of clusters, but for the tick, which is O(n^2) of
// cheap steps in n clusters. Allocates in the constructor only. Results do not depend on how the
// stream is cut into calls.
// Source: own design; nobody's published algorithm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/coarse_index.hpp"
#include "algorithms/fast/contour.hpp"
#include "algorithms/fast/event_clock.hpp"
#include "algorithms/fast/frame.hpp"
#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/halves.hpp"
#include "algorithms/fast/mean_update.hpp"
#include "algorithms/fast/noise_tiles.hpp"
#include "algorithms/fast/orphan_grid.hpp"
#include "algorithms/fast/owner_grid.hpp"
#include "algorithms/fast/pairs.hpp"
#include "algorithms/fast/settings.hpp"
#include "algorithms/fast/split.hpp"
#include "algorithms/fast/support_map.hpp"
#include "algorithms/fast/track.hpp"
#include "asap/algorithms/cluster.hpp"
#include "asap/algorithms/cluster_tracker_config.hpp"
#include "asap/core/event.hpp"

namespace asap::fast {

class Engine {
 public:
  static constexpr std::int32_t kNoId = -1;

  struct Counters {
    std::uint64_t rejected = 0;     // outside the frame
    std::uint64_t unsupported = 0;  // without company
    std::uint64_t refused = 0;      // births, for want of a slot
    std::uint64_t merges = 0;
    std::uint64_t splits = 0;
  };

  // Precondition: the configuration is checked.
  explicit Engine(const ClusterTrackerConfig& config);

  // labels[i]: the id of the cluster that takes events[i], or kNoId; null: nobody asks.
  void process(EventSpan events, std::int32_t* labels) noexcept;

  // Time has come to t_us without events: clusters starve, coast and die.
  void advance_to(std::int64_t t_us) noexcept;

  // The listed clusters at t_us, by id, if nothing comes until then; a t_us of the past is the
  // latest time. Allocates only where `clusters` must grow.
  void read(std::int64_t t_us, std::vector<Cluster>& clusters) const;

  // The latest stamp.
  std::int64_t latest_us() const noexcept { return clock_.latest_us(); }

  void set_keep(double gamma, bool filtered_upstream) noexcept;
  void reset() noexcept;

  const Counters& counters() const noexcept { return counters_; }

 private:
  using Slot = Tracks::Slot;

  // ---- per event ----
  std::int32_t process(const Event& event) noexcept;
  std::int32_t give(Slot slot, OwnerGrid::Cell& cell, const Event& event, Stamp now) noexcept;
  std::int32_t search(const Event& event, std::size_t cell, Stamp now) noexcept;
  Slot nearest_around(const Event& event, std::size_t cell, Stamp now) noexcept;
  Slot try_birth(const Event& event, std::size_t cell, Stamp now) noexcept;
  Slot begin_track(float x, float y) noexcept;

  // ---- per tick ----
  void clear_maps() noexcept;
  void start() noexcept;
  void tick() noexcept;
  void tend_clusters() noexcept;
  bool tend(Slot slot, const Tick& tick) noexcept;
  void confirm(Slot slot) noexcept;
  void tend_frame() noexcept;
  void measure_noise() noexcept;
  void merge_pairs(float dt_s) noexcept;
  void split_next() noexcept;
  void split(Slot slot) noexcept;
  void halve(Slot slot) noexcept;
  Slot begin_part(Slot parent, const PartFinder::Part& part, float share) noexcept;
  void remove(Slot slot) noexcept;

  ClusterTrackerConfig config_;
  Settings settings_;
  Frame frame_;
  CellMap map_;
  EventClock clock_;
  SupportMap support_;
  OwnerGrid owners_;
  OrphanGrid orphans_;
  NoiseTiles noise_;
  CoarseIndex coarse_;
  Tracks tracks_;
  Pairs pairs_;
  PartFinder parts_;
  HalfFinder halves_;
  std::size_t next_split_ = 0;
  Reciprocals reciprocals_;
  DirectionTable directions_;
  Counters counters_;
  Stamp next_tick_ = 0;
  bool clusters_are_due_ = true;  // the next tick's half
  std::uint64_t started_us_ = 0;
  std::uint64_t clusters_us_ = 0;  // when each half ran last
  std::uint64_t frame_us_ = 0;
  std::uint64_t noise_us_ = 0;
  std::int32_t support_window_us_ = 0;  // as long as the noise allows
  float noise_hz_ = 0;                  // per pixel, that reaches the tracks [lambda_eff]
  float birth_threshold_ = 0;           // [theta]
  std::int32_t next_id_ = 0;
};

}  // namespace asap::fast
