// OwnerCellTracker: the first design of the fast tracker, kept as a rival of the second. Cells of
// 4 px remember which cluster took the last event there, a cluster begins where unassociated events
// are dense, everything else waits for a tick of a millisecond. One radius serves all objects, and
// a noise filter belongs in front. No support map, contour, contact or coasting. Behaves as its
// prototype did, except that time does not wrap. A baseline of an experiment, not a product. One
// thread at a time. O(1) per event but for the tick; allocates in the constructor and for what it
// returns. Source: own design.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "algorithms/fast/association.hpp"
#include "algorithms/fast/kalman.hpp"
#include "algorithms/fast/lifecycle.hpp"
#include "algorithms/fast/split.hpp"
#include "algorithms/fast/time.hpp"
#include "algorithms/fast/track.hpp"
#include "algorithms/fast/update.hpp"
#include "algorithms/sensor_frame.hpp"
#include "asap/algorithms/cluster.hpp"
#include "asap/core/event.hpp"
#include "study/owner_cell_merge.hpp"

namespace asap {

// The noise rate as the first design measures it: a low pass over the rate of the unassociated
// events, and the count from which they are more than noise. O(1), no allocation.
class OrphanNoise {
 public:
  void count() noexcept { ++orphans_; }

  // At the tick: elapsed_s since the last one; area_px2 where no cluster is. `warming`: nothing may
  // be born yet. Births look at around_px2 for memory_s.
  void update(float elapsed_s, float area_px2, bool warming, float around_px2,
              float memory_s) noexcept {
    const float raw_hz = static_cast<float>(orphans_) / (area_px2 * elapsed_s);
    rate_hz_ += (warming ? 0.2F : 0.03F) * (raw_hz - rate_hz_);
    orphans_ = 0;
    if (warming) return;
    const float expected = rate_hz_ * around_px2 * memory_s;
    threshold_ = std::max(kLeast, expected + 4 * std::sqrt(expected) + 2);
  }

  // Per pixel.
  float rate_hz() const noexcept { return rate_hz_; }

  // Events; infinite until it is warm.
  float threshold() const noexcept { return threshold_; }

 private:
  static constexpr float kLeast = 6;  // events

  std::uint64_t orphans_ = 0;                                 // since the last tick
  float rate_hz_ = 0;                                         // per pixel
  float threshold_ = std::numeric_limits<float>::infinity();  // events
};

struct OwnerCellConfig {
  int width;           // px
  int height;          // px
  int radius_px = 16;  // of the gate; must cover the largest object
};

class OwnerCellTracker {
 public:
  using Config = OwnerCellConfig;

  static constexpr std::size_t kSlots = 128;

  // Throws std::invalid_argument that names the bad field.
  explicit OwnerCellTracker(const Config& config);

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // As above, and labels[i] is the id of the cluster that took events[i]; -1 for unassociated
  // events and for a cluster that is not confirmed yet. Throws std::invalid_argument if the sizes
  // differ.
  void process(EventSpan events, std::span<std::int32_t> labels);

  // The confirmed clusters, sorted by id, positions predicted for t_us. A t_us of the past
  // counts as the latest time.
  std::vector<Cluster> clusters() const { return clusters_at(clock_.latest_us()); }
  std::vector<Cluster> clusters_at(std::int64_t t_us) const;

  // The fraction of the events that reaches the tracker, in [0, 1]: the means remember fewer.
  // Throws std::invalid_argument if gamma is out of range.
  void set_keep(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  // Of noise, as the tracker sees it, per pixel.
  float noise_hz() const noexcept { return noise_.rate_hz(); }

  const Config& config() const noexcept { return config_; }

 private:
  using Slot = fast::Tracks::Slot;

  // ---- per event ----
  std::int32_t process(const Event& event) noexcept;
  float distance2(Slot slot, const Event& event) const noexcept;
  Slot nearest_around(const Event& event, std::size_t cell) noexcept;
  Slot try_birth(const Event& event, std::size_t cell) noexcept;
  Slot begin_track(float x, float y) noexcept;
  void take(Slot slot, const Event& event) noexcept;

  // ---- per tick ----
  void start() noexcept;
  void tick() noexcept;
  void measure_noise(float elapsed_s) noexcept;
  void merge_all() noexcept;
  bool tend(Slot slot) noexcept;
  void remove(Slot slot) noexcept;
  void split(Slot slot) noexcept;
  float coarse(float position) const noexcept { return position * coarse_scale_; }

  Config config_;
  SensorFrame frame_;
  float radius2_;       // px^2
  float coarse_scale_;  // of positions in the index, whose cells are of 32 units: side R
  fast::CellMap map_;
  fast::EventClock clock_;
  fast::OwnerGrid owners_;
  fast::BirthGrid births_;
  fast::CoarseIndex coarse_;
  fast::Tracks tracks_;
  std::vector<std::uint64_t> born_us_;
  OwnerCellMerge merge_;
  OrphanNoise noise_;
  fast::PartFinder parts_;
  fast::Reciprocals reciprocals_;
  fast::KalmanRule kalman_;

  std::uint64_t started_us_ = 0;
  std::uint64_t ticked_us_ = 0;
  std::uint64_t split_us_ = 0;
  std::int32_t next_id_ = 0;
  std::uint64_t rejected_ = 0;
};

}  // namespace asap
