#include "asap/algorithms/feature_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
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

TEST(FeatureTracker, TheStreamMayBeCutAnywhereAndResetIsANewTracker) {
  for (const CornerSource source : kSources) {
    FeatureTracker tracker(with(source));
    const Labels whole = labels_of(tracker, stream());
    tracker.process(std::vector<Event>{{.x = 346, .y = 0, .p = 0, .t = 1LL << 60}});
    EXPECT_EQ(tracker.rejected(), 1U);
    tracker.reset();
    EXPECT_EQ(tracker.rejected(), 0U);
    EXPECT_TRUE(tracker.tracks().empty());
    Labels parts(whole.size(), -7);
    for (std::size_t i = 0; i < parts.size();) {
      const std::size_t n = std::min<std::size_t>(i % 997 + 1, parts.size() - i);
      tracker.process(asap::EventSpan(stream()).subspan(i, n), std::span(parts).subspan(i, n));
      i += n;
    }
    EXPECT_EQ(parts, whole);
  }
}

TEST(FeatureTracker, DropsAndCountsEventsOutsideTheFrame) {
  for (const CornerSource source : kSources) {
    FeatureTracker tracker({.width = 20, .height = 10, .detector = source});
    EXPECT_EQ(labels_of(tracker, {{.x = 20, .y = 0, .p = 0, .t = 0},
                                  {.x = 0, .y = 10, .p = 0, .t = 0},
                                  {.x = 65535, .y = 65535, .p = 0, .t = 0}}),
              (Labels{-1, -1, -1}));
    EXPECT_EQ(tracker.rejected(), 3U);
  }
}

TEST(FeatureTracker, KeepIsChecked) {
  FeatureTracker told(with(CornerSource::arc_star));
  told.set_gamma(0);
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(told.set_gamma(bad), std::invalid_argument);
  }
}

std::string error_of(const asap::FeatureConfig& config) {
  return asap::test::error_of([&] { FeatureTracker{config}; });
}

TEST(FeatureTracker, NamesTheBadField) {
  EXPECT_EQ(error_of({.width = 0, .height = 10}), "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 16385}), "height = 16385: must be 1 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .window = 0}),
            "window = 0: must be 1 to 65535 corner events");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .window = 65536}),
            "window = 65536: must be 1 to 65535 corner events");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .radius = -1}),
            "radius = -1: must be 0 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .radius = 16385}),
            "radius = 16385: must be 0 to 16384 px");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .min_neighbours = -1}),
            "min_neighbours = -1: must be 0 to 7");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .min_neighbours = 8}),
            "min_neighbours = 8: must be 0 to 7");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .window_time = microseconds(-1)}),
            "window_us = -1: must be 0 to 1000000000 us");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .velocity_window = microseconds(0)}),
            "velocity_us = 0: must be 1 to 1000000000 us");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .velocity_window = microseconds(1'000'000'001)}),
            "velocity_us = 1000000001: must be 1 to 1000000000 us");
  EXPECT_EQ(error_of({.width = 10, .height = 10, .detector = CornerSource(99)}),
            "detector = 99: must be a CornerSource");
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

TEST(FeatureTracker, MovesWithItsTracks) {
  FeatureTracker tracker(with(CornerSource::arc_star));
  const Labels labels = labels_of(tracker, stream());
  tracker.reset();
  FeatureTracker moved(std::move(tracker));
  EXPECT_EQ(labels_of(moved, stream()), labels);
  const std::size_t tracks = moved.tracks().size();
  FeatureTracker other(with(CornerSource::every_event));
  other = std::move(moved);
  EXPECT_EQ(other.tracks().size(), tracks);
  EXPECT_EQ(other.config().detector, CornerSource::arc_star);
}

TEST(FeatureTracker, LabelsOfAnotherSizeAreRefused) {
  FeatureTracker tracker({.width = 10, .height = 10});
  Labels labels(2);
  EXPECT_THROW(tracker.process(std::vector<Event>(3), labels), std::invalid_argument);
}

TEST(FeatureTracker, AllocatesOnlyInTheConstructor) {
  for (const CornerSource source : kSources) {
    FeatureTracker tracker(with(source));
    Labels labels(stream().size());
    const std::size_t before = asap::test::allocations();
    tracker.process(stream(), labels);
    tracker.set_gamma(0.5);
    tracker.reset();
    EXPECT_EQ(asap::test::allocations(), before);
  }
}

}  // namespace
}  // namespace feature_tracker_test
