#include "algorithms/motion/region_tracks.hpp"

#include <algorithm>

namespace asap::inline v0_1::motion {
namespace {

constexpr std::size_t kMostTracks = 64;
constexpr double kReach_px = 25;
constexpr int kListed = 4;      // hits from which a track is told
constexpr int kMostMisses = 2;  // in a row, of a track that is told; another ends with the first

double s_of(std::int64_t us) noexcept { return 1e-6 * static_cast<double>(us); }

}  // namespace

RegionTracks::RegionTracks() {
  tracks_.reserve(kMostTracks);
  pairs_.reserve(kMostTracks * MotionRegions::kMost);
  is_free_.reserve(MotionRegions::kMost);
}

bool RegionTracks::Track::is_listed() const noexcept { return hits >= kListed; }

void RegionTracks::step(std::span<const Region> regions) noexcept {
  for (Track& track : tracks_) {
    track.centre += s_of(kStep_us) * track.velocity;
    track.age_us += kStep_us;
    ++track.misses;
  }
  find_pairs(regions);
  is_free_.assign(regions.size(), 1);
  for (const Pair& pair : pairs_) {
    Track& track = tracks_[pair.track];
    if (track.misses == 0 || is_free_[pair.region] == 0) continue;
    is_free_[pair.region] = 0;
    correct(track, regions[pair.region]);
  }
  end_missed();
  for (std::size_t i = 0; i < regions.size() && tracks_.size() < kMostTracks; ++i) {
    if (is_free_[i] == 0) continue;
    const Region& region = regions[i];
    tracks_.push_back({.id = next_id_++,
                       .centre = region.centre,
                       .half_size = region.half_size,
                       .velocity = region.velocity,
                       .size = region.size,
                       .t_last = region.t_last,
                       .age_us = 0,
                       .hits = 1,
                       .misses = 0});
  }
}

void RegionTracks::find_pairs(std::span<const Region> regions) noexcept {
  pairs_.clear();
  for (std::size_t track = 0; track < tracks_.size(); ++track) {
    for (std::size_t region = 0; region < regions.size(); ++region) {
      const double distance = (tracks_[track].centre - regions[region].centre).norm();
      if (distance < kReach_px) pairs_.push_back({distance, track, region});
    }
  }
  std::sort(pairs_.begin(), pairs_.end(),
            [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
}

void RegionTracks::correct(Track& track, const Region& region) noexcept {
  constexpr double kCentreGain = 0.4;
  constexpr double kGain = 0.3;  // on velocity and size
  track.centre += kCentreGain * (region.centre - track.centre);
  track.velocity += kGain * (region.velocity - track.velocity);
  track.half_size += kGain * (region.half_size - track.half_size);
  track.size = region.size;
  track.t_last = region.t_last;
  ++track.hits;
  track.misses = 0;
}

void RegionTracks::end_missed() noexcept {
  std::erase_if(tracks_, [](const Track& track) {
    return track.misses > (track.is_listed() ? kMostMisses : 0);
  });
}

void RegionTracks::read(std::vector<TrackedObject>& objects, std::int64_t ahead_us,
                        bool is_known) const {
  objects.clear();
  for (const Track& track : tracks_) {
    if (!track.is_listed() || track.misses + ahead_us / kStep_us > kMostMisses) continue;
    const Eigen::Vector2d centre = track.centre + s_of(ahead_us) * track.velocity;
    const Eigen::Vector2d corner = centre - track.half_size;
    objects.push_back({.id = track.id,
                       .x = centre.x(),
                       .y = centre.y(),
                       .vx = track.velocity.x(),
                       .vy = track.velocity.y(),
                       .left = corner.x(),
                       .top = corner.y(),
                       .width = 2 * track.half_size.x(),
                       .height = 2 * track.half_size.y(),
                       .size = track.size,
                       .t_last = track.t_last,
                       .age_us = track.age_us + ahead_us,
                       .independent = is_known ? 1.0 : -1.0});
  }
}

void RegionTracks::clear() noexcept {
  tracks_.clear();
  next_id_ = 0;
}

}  // namespace asap::inline v0_1::motion
