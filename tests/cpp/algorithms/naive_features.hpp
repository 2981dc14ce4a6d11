// The feature tracker as it is defined: lists that are searched from end to end.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "asap/algorithms/feature_tracker.hpp"
#include "asap/core/event.hpp"

namespace asap::test {

class NaiveFeatures {
 public:
  struct Track {
    std::int64_t id, x, y, size, t_first, t_last;
  };

  explicit NaiveFeatures(const FeatureConfig& config) : config_(config) {}

  // The id of the track that took the event, or -1.
  std::int64_t update(const Event& corner) {
    const std::int64_t t = fifo_.empty() ? corner.t : std::max(corner.t, fifo_.back());
    surface_[{corner.x, corner.y}] = t;
    fifo_.push_back(t);
    const auto is_old = [&] {
      return static_cast<std::uint64_t>(t) - static_cast<std::uint64_t>(fifo_.front()) >=
             static_cast<std::uint64_t>(config_.window_time.count());
    };
    while (fifo_.size() > static_cast<std::size_t>(config_.window) && is_old()) fifo_.pop_front();
    const std::int64_t old = fifo_.front();
    if (corner.x < 1 || corner.x > config_.width - 2 || corner.y < 1 ||
        corner.y > config_.height - 2) {
      return -1;
    }

    int company = t > old ? 0 : -1;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        const auto found = surface_.find({corner.x + dx, corner.y + dy});
        if (found != surface_.end() && found->second > old) ++company;
      }
    }
    if (company <= config_.min_neighbours) return -1;

    Track taken{next_id_, corner.x, corner.y, 1, t, t};
    bool is_new = true;
    for (auto track = tracks.begin(); track != tracks.end();) {
      const std::int64_t dx = track->x - corner.x;
      const std::int64_t dy = track->y - corner.y;
      if (dx * dx + dy * dy > std::int64_t{config_.radius} * config_.radius) {
        ++track;
      } else if (is_new) {
        is_new = false;
        *track = {track->id, corner.x, corner.y, track->size + 1, track->t_first, t};
        taken = *track++;
      } else {
        track = tracks.erase(track);
      }
    }
    if (is_new) {
      tracks.push_back(taken);
      ++next_id_;
    }
    std::erase_if(tracks, [&](const Track& track) { return track.t_last <= old; });
    return taken.id;
  }

  std::vector<Track> tracks;  // in the order of their creation

 private:
  FeatureConfig config_;
  std::map<std::pair<int, int>, std::int64_t> surface_;
  std::deque<std::int64_t> fifo_;
  std::int64_t next_id_ = 0;
};

}  // namespace asap::test
