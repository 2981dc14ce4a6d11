#include "asap/algorithms/feature_tracker.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <variant>

#include "algorithms/feature_tracks.hpp"
#include "algorithms/sensor_frame.hpp"
#include "algorithms/smooth_gamma.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

class FeatureTracker::Impl {
  // The detector that takes every event of the frame for a corner.
  class EveryEvent {
   public:
    EveryEvent(int width, int height) : frame_(width, height) {}

    void process(EventSpan events, std::span<std::uint8_t> corners) noexcept {
      for (std::size_t i = 0; i < events.size(); ++i) {
        corners[i] = frame_.contains(events[i]);
        rejected_ += corners[i] == 0;
      }
    }

    void reset() noexcept { rejected_ = 0; }
    std::uint64_t rejected() const noexcept { return rejected_; }

   private:
    SensorFrame frame_;
    std::uint64_t rejected_ = 0;
  };

  using Detector = std::variant<EveryEvent, EFast, ArcStar, EHarris, FAHarris>;

  static Detector make_detector(const Config& config) {
    const int width = config.width;
    const int height = config.height;
    switch (config.detector) {
      case CornerSource::every_event:
        return EveryEvent(width, height);
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

 public:
  explicit Impl(const Config& given)
      : config(given), tracks(given), detector(make_detector(given)) {}

  // Calls visit(i, id) for every event: the detector labels a block, then the tracks take its
  // corners.
  template <class Visit>
  void for_each_label(EventSpan events, Visit&& visit) noexcept {
    if (gamma.take(events.size())) tracks.set_gamma(gamma.value());
    constexpr std::size_t kBlock = 256;
    std::array<std::uint8_t, kBlock> corners;
    const auto label = [&](auto& any) {
      for (std::size_t first = 0; first < events.size(); first += kBlock) {
        const std::size_t count = std::min(kBlock, events.size() - first);
        any.process(events.subspan(first, count), std::span(corners).first(count));
        for (std::size_t i = 0; i < count; ++i) {
          const Event& event = events[first + i];
          visit(first + i, corners[i] != 0 ? tracks.update(event) : FeatureTracks::kNoId);
        }
      }
    };
    std::visit(label, detector);
  }

  Config config;
  FeatureTracks tracks;
  Detector detector;
  SmoothGamma gamma;
};

FeatureTracker::FeatureTracker(const Config& config) : impl_(std::make_unique<Impl>(config)) {}
FeatureTracker::~FeatureTracker() = default;
FeatureTracker::FeatureTracker(FeatureTracker&&) noexcept = default;
FeatureTracker& FeatureTracker::operator=(FeatureTracker&&) noexcept = default;

void FeatureTracker::process(EventSpan events) noexcept {
  impl_->for_each_label(events, [](std::size_t, std::int32_t) {});
}

void FeatureTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  impl_->for_each_label(events, [&](std::size_t i, std::int32_t id) { labels[i] = id; });
}

std::vector<FeatureTrack> FeatureTracker::tracks() const {
  std::vector<FeatureTrack> read;
  tracks(read);
  return read;
}

void FeatureTracker::tracks(std::vector<FeatureTrack>& tracks) const { impl_->tracks.read(tracks); }

void FeatureTracker::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  impl_->gamma.tell(gamma);
}

void FeatureTracker::reset() noexcept {
  std::visit([](auto& detector) { detector.reset(); }, impl_->detector);
  impl_->tracks.clear();
  impl_->gamma = {};
}

std::uint64_t FeatureTracker::rejected() const noexcept {
  return std::visit([](const auto& detector) { return detector.rejected(); }, impl_->detector);
}

const FeatureTracker::Config& FeatureTracker::config() const noexcept { return impl_->config; }

}  // namespace asap::inline v0_1
