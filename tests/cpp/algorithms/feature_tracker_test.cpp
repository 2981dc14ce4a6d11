#include "asap/algorithms/feature_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/feature_tracks.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "support/allocation_counter.hpp"

namespace feature_tracker_test {
namespace {

using asap::CornerSource;
using asap::Event;
using asap::FeatureTracker;
using Labels = std::vector<std::int32_t>;

constexpr CornerSource kSources[] = {CornerSource::every_event, CornerSource::e_fast,
                                     CornerSource::arc_star, CornerSource::e_harris,
                                     CornerSource::fa_harris};

const std::vector<Event>& stream() {
  static const auto events = asap::test::golden_corner_stream(60'000);
  return events;
}

asap::FeatureConfig with(CornerSource source) {
  return {.width = 346, .height = 260, .detector = source, .min_neighbours = 0};
}

Labels labels_of(FeatureTracker& tracker, const std::vector<Event>& events) {
  Labels labels(events.size(), -7);
  tracker.process(events, labels);
  return labels;
}

// Every event of the stream lies in the frame.
struct EveryEvent {
  explicit EveryEvent(const asap::EFastConfig&) {}
  void process(asap::EventSpan, std::span<std::uint8_t> corners) {
    std::fill(corners.begin(), corners.end(), 1);
  }
};

// Returns the largest id.
template <class Detector>
std::int32_t expect_tracks_of(CornerSource source) {
  FeatureTracker tracker(with(source));
  const Labels labels = labels_of(tracker, stream());

  std::vector<std::uint8_t> corners(stream().size());
  Detector({.width = 346, .height = 260}).process(stream(), corners);
  asap::FeatureTracks tracks(with(source));
  Labels expected;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    expected.push_back(corners[i] != 0 ? tracks.update(stream()[i]) : -1);
  }
  EXPECT_EQ(labels, expected);
  return *std::max_element(labels.begin(), labels.end());
}

TEST(FeatureTracker, FollowsTheCornersOfItsDetector) {
  EXPECT_GT(expect_tracks_of<EveryEvent>(CornerSource::every_event), 100);
  EXPECT_GT(expect_tracks_of<asap::ArcStar>(CornerSource::arc_star), 3);
  EXPECT_GE(expect_tracks_of<asap::EFast>(CornerSource::e_fast), 0);
  EXPECT_GE(expect_tracks_of<asap::EHarris>(CornerSource::e_harris), 0);
  expect_tracks_of<asap::FAHarris>(CornerSource::fa_harris);  // too few corners for company
}

// EveryAlgorithm has the default detector alone.
TEST(FeatureTracker, AnyDetectorBeginsAnewAndAllocatesNothing) {
  for (const CornerSource source : kSources) {
    FeatureTracker tracker(with(source));
    const Labels whole = labels_of(tracker, stream());
    Labels again(whole.size());
    const std::size_t before = asap::test::allocations();
    tracker.reset();
    tracker.process(stream(), again);
    EXPECT_EQ(asap::test::allocations(), before);
    EXPECT_EQ(again, whole);
  }
}

}  // namespace
}  // namespace feature_tracker_test
