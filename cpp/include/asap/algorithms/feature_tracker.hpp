// FeatureTracker: finds corners in a stream of events and follows them: a corner detector, then
// FeatureTracks. One thread at a time. process() is O(1) per event and allocates nothing; all
// memory is taken in the constructor. For another detector, or another's labels, give its corners
// to FeatureTracks, or to a FeatureTracker of CornerSource::every_event.
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "asap/algorithms/arc_star.hpp"
#include "asap/algorithms/e_fast.hpp"
#include "asap/algorithms/e_harris.hpp"
#include "asap/algorithms/every_event.hpp"
#include "asap/algorithms/fa_harris.hpp"
#include "asap/algorithms/feature_config.hpp"
#include "asap/algorithms/feature_track.hpp"
#include "asap/algorithms/feature_tracks.hpp"
#include "asap/core/event.hpp"

namespace asap {

class FeatureTracker {
 public:
  using Config = FeatureConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit FeatureTracker(const Config& config);

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // As above, and labels[i] is the id of the track that took events[i]: -1 where it is no corner, a
  // corner without company, or dropped. Throws std::invalid_argument if the sizes differ.
  void process(EventSpan events, std::span<std::int32_t> labels);

  // The tracks, first created first.
  std::vector<FeatureTrack> tracks() const;

  // The same without allocation once `tracks` has the capacity.
  void tracks(std::vector<FeatureTrack>& tracks) const { tracks_.read(tracks); }

  // The fraction of the events that reaches the tracker, in [0, 1]. Checked, without effect: the
  // published rule counts corner events and so stretches in time by itself.
  void set_keep(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept { return config_; }

 private:
  using Detector = std::variant<EveryEvent, EFast, ArcStar, EHarris, FAHarris>;

  static Detector make_detector(const Config& config);

  template <class Visit>
  void for_each_label(EventSpan events, Visit&& visit) noexcept;

  Config config_;
  Detector detector_;
  FeatureTracks tracks_;
};

}  // namespace asap
