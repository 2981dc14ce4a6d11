// RegionTracks: regions of moments that follow each other, as things with an id, a place and a
// velocity. The nearest pairs go together, nearest first. One thread. O(tracks x regions) per step;
// allocates in the constructor only.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/motion/motion_regions.hpp"
#include "asap/algorithms/cluster_tracker.hpp"

namespace asap::inline v0_1::motion {

class RegionTracks {
 public:
  RegionTracks();

  static constexpr std::int64_t kStep_us = 10'000;

  // kStep_us after the step before. Regions without a track begin one while there is room.
  void step(std::span<const Region> regions) noexcept;

  bool empty() const noexcept { return tracks_.empty(); }

  // The listed tracks, sorted by id, predicted `ahead_us` beyond the last step, which miss no more
  // steps on the way than a track survives.
  void read(std::vector<TrackedObject>& objects, std::int64_t ahead_us, bool is_known) const;

  void clear() noexcept;

 private:
  struct Track {
    std::int64_t id;
    Eigen::Vector2d centre;
    Eigen::Vector2d half_size;
    Eigen::Vector2d velocity;
    std::int64_t size;
    std::int64_t t_last;
    std::int64_t age_us;
    int hits;
    int misses;
    bool is_listed() const noexcept;
  };
  struct Pair {
    double distance;
    std::size_t track;
    std::size_t region;
  };

  void find_pairs(std::span<const Region> regions) noexcept;
  static void correct(Track& track, const Region& region) noexcept;
  void end_missed() noexcept;

  std::vector<Track> tracks_;  // by id
  std::vector<Pair> pairs_;
  std::vector<std::uint8_t> is_free_;  // of each region
  std::int64_t next_id_ = 0;
};

}  // namespace asap::inline v0_1::motion
