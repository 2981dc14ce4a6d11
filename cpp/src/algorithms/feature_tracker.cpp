#include "asap/algorithms/feature_tracker.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "asap/core/check.hpp"

namespace asap {

FeatureTracker::Detector FeatureTracker::make_detector(const Config& config) {
  const int width = config.width;
  const int height = config.height;
  switch (config.detector) {
    case CornerSource::every_event:
      return EveryEvent({.width = width, .height = height});
    case CornerSource::e_fast:
      return EFast({.width = width, .height = height});
    case CornerSource::arc_star:
      return ArcStar({.width = width, .height = height});
    case CornerSource::e_harris:
      return EHarris({.width = width, .height = height});
    case CornerSource::fa_harris:
      return FAHarris({.width = width, .height = height});
  }
  throw_bad_value("detector", std::to_string(static_cast<int>(config.detector)),
                  "must be a CornerSource");
}

FeatureTracker::FeatureTracker(const Config& config)
    : config_(checked(config)), detector_(make_detector(config_)), tracks_(config_) {}

// Calls visit(i, id) for every event: the detector labels a block, then the tracks take its
// corners.
template <class Visit>
void FeatureTracker::for_each_label(EventSpan events, Visit&& visit) noexcept {
  constexpr std::size_t kBlock = 256;
  std::array<std::uint8_t, kBlock> corners;
  std::visit(
      [&](auto& detector) {
        for (std::size_t first = 0; first < events.size(); first += kBlock) {
          const std::size_t count = std::min(kBlock, events.size() - first);
          detector.process(events.subspan(first, count), std::span(corners).first(count));
          for (std::size_t i = 0; i < count; ++i) {
            const Event& event = events[first + i];
            visit(first + i, corners[i] != 0 ? tracks_.update(event) : FeatureTracks::kNoId);
          }
        }
      },
      detector_);
}

void FeatureTracker::process(EventSpan events) noexcept {
  for_each_label(events, [](std::size_t, std::int32_t) {});
}

void FeatureTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  for_each_label(events, [&](std::size_t i, std::int32_t id) { labels[i] = id; });
}

std::vector<FeatureTrack> FeatureTracker::tracks() const {
  std::vector<FeatureTrack> tracks;
  tracks_.read(tracks);
  return tracks;
}

void FeatureTracker::set_keep(double gamma) {
  std::visit([&](auto& detector) { detector.set_keep(gamma); }, detector_);
}

void FeatureTracker::reset() noexcept {
  std::visit([](auto& detector) { detector.reset(); }, detector_);
  tracks_.clear();
}

std::uint64_t FeatureTracker::rejected() const noexcept {
  return std::visit([](const auto& detector) { return detector.rejected(); }, detector_);
}

}  // namespace asap
