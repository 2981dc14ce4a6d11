// FeatureTracks: the rule by which FeatureTracker follows corners; see feature_tracker.hpp, which
// names the source. One thread. update() is O(1), whatever the number of tracks: no two are within
// the radius of each other. No allocation after construction. With a window_time of 0 the results
// are those of the release, which searches linearly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/cell_grid.hpp"
#include "algorithms/centre_grid.hpp"
#include "algorithms/sensor_frame.hpp"
#include "asap/algorithms/feature_tracker.hpp"
#include "asap/core/event.hpp"
#include "core/event_clock.hpp"

namespace asap::inline v0_1 {

// The velocity of a point from its positions, by regression of x and y on t in which an older
// position weighs less: by memory / (memory + dt) with every step dt. Times count from the newest
// position, so nothing grows and no digits are lost.
class DiscountedMotion {
 public:
  struct Velocity {
    double x;
    double y;
  };

  // A position `dt` after the one before; `memory` > 0 is in the unit of `dt`.
  void add(double x, double y, double dt, double memory) noexcept {
    const double keep = memory / (memory + dt);
    // Old before new: each line uses the sums of the position before.
    tt_ = keep * (tt_ - dt * (2 * t_ - dt * n_));
    xt_ = keep * (xt_ - dt * x_);
    yt_ = keep * (yt_ - dt * y_);
    t_ = keep * (t_ - dt * n_);
    x_ = keep * x_ + x;
    y_ = keep * y_ + y;
    n_ = keep * n_ + 1;
  }

  // Per unit of time. 0 until there are positions at two times.
  Velocity velocity() const noexcept {
    const double spread = n_ * tt_ - t_ * t_;
    if (!(spread > 0)) return {0, 0};
    return {(n_ * xt_ - x_ * t_) / spread, (n_ * yt_ - y_ * t_) / spread};
  }

 private:
  // Discounted sums; t = 0 at the newest position, negative before.
  double n_ = 0;
  double t_ = 0;
  double tt_ = 0;
  double x_ = 0;
  double y_ = 0;
  double xt_ = 0;
  double yt_ = 0;
};

class FeatureTracks {
 public:
  static constexpr std::int32_t kNoId = -1;

  // Throws std::invalid_argument that names the bad field.
  explicit FeatureTracks(const FeatureConfig& config);

  // Takes one corner event of the frame. Returns the id of the track that took it, or kNoId.
  std::int32_t update(const Event& corner) noexcept;

  // Stretches the window's time for the kept fraction of the events, in [0, 1].
  void set_gamma(double gamma) noexcept;

  // Number of tracks.
  std::size_t size() const noexcept { return tracks_.size() - free_.size(); }

  // The tracks, first created first. Allocates only where `tracks` must grow.
  void read(std::vector<FeatureTrack>& tracks) const;

  // Back to the state after construction.
  void clear() noexcept;

 private:
  using Slot = CentreGrid::Slot;
  static constexpr Slot kNone = CentreGrid::kNone;

  struct Track {
    std::uint16_t x;
    std::uint16_t y;
    Slot older;  // neighbours in the order of last_us
    Slot newer;
    std::int64_t t_first;  // timestamps
    std::int64_t t_last;
    std::int64_t last_us;   // by the clock
    std::uint64_t created;  // number of creation
    std::uint64_t size;
    DiscountedMotion motion;
  };

  std::int64_t remember(const Event& corner) noexcept;
  bool is_supported(const Event& corner, std::int64_t oldest_us) const noexcept;
  Slot assign(const Event& corner) noexcept;
  void begin(Slot slot, const Event& corner) noexcept;
  void move(Slot slot, const Event& corner) noexcept;
  void end(Slot slot) noexcept;
  void append(Slot slot) noexcept;
  void unlink(Slot slot) noexcept;

  SensorFrame frame_;
  std::int32_t reach_;  // px^2, the radius squared
  int min_neighbours_;
  double velocity_us_;
  std::vector<std::int64_t> latest_us_;  // corner event of each pixel
  std::size_t window_;                   // corner events that are remembered at least
  std::int64_t window_time_us_;          // at gamma = 1
  std::uint64_t remembered_us_ = 0;      // the same at the gamma in force
  std::vector<std::int64_t> stamps_us_;  // of those that are remembered, a ring
  std::size_t oldest_stamp_ = 0;
  std::size_t stamps_ = 0;
  EventClock clock_;
  std::int64_t now_us_ = 0;  // by the clock, as are all times but timestamps

  CellGrid grid_;
  CentreGrid places_;
  std::vector<Track> tracks_;
  std::vector<Slot> free_;
  Slot oldest_ = kNone;  // ends of the order of last_us
  Slot newest_ = kNone;
  std::uint64_t created_ = 0;
};

}  // namespace asap::inline v0_1
