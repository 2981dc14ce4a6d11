// FeatureTracker: finds corners in a stream of events and follows them, event by event. A corner
// event is supported if more than m of its 8 neighbours are remembered: among the last B corner
// events, or younger than the window's time, so that the window grows with the corners of the
// scene. It then moves the first-created track within the radius to itself and ends the others
// there; where there is none it begins a track. Tracks of which no event is remembered end with the
// next supported event. One thread at a time. process() is O(1) per event, whatever the number of
// tracks, and allocates nothing; all memory is taken in the constructor. A timestamp that goes back
// by up to 1 s counts as the latest one.
// Source: the authors' release of the GRVC event feature tracker (grvc_ef_tracker), which the ASAP
// papers use, with its launch values; the window's time, ids and velocities are ours.
//
//   FeatureTracker features{{.width = 346, .height = 260}};
//   features.process(events);
//   for (const FeatureTrack& track : features.tracks()) draw(track.id, track.x, track.y);
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

// Where the corners come from: a detector with its defaults, or every event handed in is a corner,
// such as those that another detector found.
enum class CornerSource : std::uint8_t { every_event, e_fast, arc_star, e_harris, fa_harris };

struct FeatureConfig {
  int width;   // px
  int height;  // px
  CornerSource detector = CornerSource::arc_star;
  int window = 200;        // B, corner events that are remembered at least
  int radius = 5;          // px, half of w: how far a corner moves between two events
  int min_neighbours = 1;  // m: a corner needs more than these in the 3 x 3 window
  // Corner events younger than this are remembered too, up to 16384 or `window` of them; over the
  // kept fraction. 0: the release, whose tracks starve where more corners than B / 2 are in sight.
  std::chrono::microseconds window_time{40000};
  std::chrono::microseconds velocity_window{20000};  // how far back the velocity looks
};

// One corner that is followed. The Python array of tracks has these fields in this order.
struct FeatureTrack {
  std::int64_t id;       // never changes while the track lives
  double x;              // px, of its newest event
  double y;              // px
  double vx;             // px/s
  double vy;             // px/s
  std::int64_t size;     // corner events it took
  std::int64_t t_first;  // us, timestamp of the first of them
  std::int64_t t_last;   // us, of the newest
};

class FeatureTracker {
 public:
  using Config = FeatureConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit FeatureTracker(const Config& config);
  ~FeatureTracker();
  FeatureTracker(FeatureTracker&& other) noexcept;
  FeatureTracker& operator=(FeatureTracker&& other) noexcept;

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // Takes the events, and labels[i] is the id of the track that took events[i]: -1 where it is no
  // corner, an unsupported corner, or dropped. Throws std::invalid_argument if the sizes differ.
  void process(EventSpan events, std::span<std::int32_t> labels);

  // The tracks, first created first.
  std::vector<FeatureTrack> tracks() const;

  // The same without allocation once `tracks` has the capacity.
  void tracks(std::vector<FeatureTrack>& tracks) const;

  // Tells the share of the next events that thinning kept, in [0, 1]: the window's time stretches
  // by its mean, so that as many corner events are remembered. Throws std::invalid_argument if
  // gamma is out of range.
  void set_gamma(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
