#include "asap/algorithms/feature_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/feature_tracks.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

namespace feature_tracker_test {
namespace {

using std::chrono::microseconds;

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

TEST(FeatureTracker, EndsTheGoldenStreamWithItsElevenTracks) {
  FeatureTracker tracker({.width = 346, .height = 260, .window_time = microseconds(0)});
  tracker.process(asap::test::golden_corner_stream());
  const auto tracks = tracker.tracks();
  ASSERT_EQ(tracks.size(), 11U);
  double sum_x = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    sum_x += tracks[i].x;
    if (i > 0) {
      EXPECT_LT(tracks[i - 1].id, tracks[i].id);
    }
  }
  EXPECT_EQ(sum_x, 1973);
  std::vector<asap::FeatureTrack> read(100);
  tracker.tracks(read);
  EXPECT_EQ(read.size(), 11U);
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

TEST(FeatureTracker, NamesTheBadField) {
  const std::pair<const char*, asap::FeatureConfig> refused[] = {
      {"width = 0: ", {.width = 0, .height = 9}},
      {"height = 16385: ", {.width = 9, .height = 16385}},
      {"window = 0: ", {.width = 9, .height = 9, .window = 0}},
      {"window = 65536: ", {.width = 9, .height = 9, .window = 65536}},
      {"radius = -1: ", {.width = 9, .height = 9, .radius = -1}},
      {"radius = 16385: ", {.width = 9, .height = 9, .radius = 16385}},
      {"min_neighbours = -1: ", {.width = 9, .height = 9, .min_neighbours = -1}},
      {"min_neighbours = 8: ", {.width = 9, .height = 9, .min_neighbours = 8}},
      {"window_us = -1: ", {.width = 9, .height = 9, .window_time = microseconds(-1)}},
      {"velocity_us = 0: ", {.width = 9, .height = 9, .velocity_window = microseconds(0)}},
      {"velocity_us = 1000000001: ",
       {.width = 9, .height = 9, .velocity_window = microseconds(1'000'000'001)}},
      {"detector = 99: ", {.width = 9, .height = 9, .detector = CornerSource(99)}},
  };
  for (const auto& [named, config] : refused) {
    const std::string error = asap::test::error_of([&] { FeatureTracker{config}; });
    EXPECT_TRUE(error.starts_with(named)) << error;
  }
}

TEST(FeatureTracker, TakesTheLimits) {
  EXPECT_NO_THROW(FeatureTracker({.width = 1,
                                  .height = 1,
                                  .window = 1,
                                  .radius = 0,
                                  .min_neighbours = 0,
                                  .window_time = microseconds(0),
                                  .velocity_window = microseconds(1)}));
  EXPECT_NO_THROW(FeatureTracker({.width = 16384,
                                  .height = 1,
                                  .window = 65535,
                                  .radius = 16384,
                                  .min_neighbours = 7,
                                  .window_time = microseconds(1'000'000'000),
                                  .velocity_window = microseconds(1'000'000'000)}));
  EXPECT_NO_THROW(FeatureTracker({.width = 1, .height = 16384}));
}

}  // namespace
}  // namespace feature_tracker_test
