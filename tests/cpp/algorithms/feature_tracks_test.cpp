#include "algorithms/feature_tracks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_features.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "core/random.hpp"

namespace asap::feature_tracks_test {
namespace {

using std::chrono::microseconds;

using asap::Event;
using asap::FeatureConfig;
using asap::FeatureTrack;
using asap::FeatureTracks;

std::vector<Event> golden_corners() {
  const auto events = asap::test::golden_corner_stream();
  std::vector<std::uint8_t> labels(events.size());
  asap::ArcStar({.width = 346, .height = 260}).process(events, labels);
  std::vector<Event> corners;
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (labels[i] != 0) corners.push_back(events[i]);
  }
  return corners;
}

struct Golden {
  int min_neighbours;
  std::size_t tracks, sum_of_sizes, largest;
  double sum_x, sum_y;
};

class FeatureTracksGolden : public testing::TestWithParam<Golden> {};

TEST_P(FeatureTracksGolden, Vector) {
  const Golden& golden = GetParam();
  const auto corners = golden_corners();
  ASSERT_EQ(corners.size(), 7354U);
  FeatureTracks tracks({.width = 346,
                        .height = 260,
                        .min_neighbours = golden.min_neighbours,
                        .window_time = microseconds(0)});
  std::size_t sum_of_sizes = 0;
  std::size_t largest = 0;
  for (const Event& corner : corners) {
    tracks.update(corner);
    sum_of_sizes += tracks.size();
    largest = std::max(largest, tracks.size());
  }
  EXPECT_EQ(tracks.size(), golden.tracks);
  EXPECT_EQ(sum_of_sizes, golden.sum_of_sizes);
  EXPECT_EQ(largest, golden.largest);
  std::vector<FeatureTrack> read;
  tracks.read(read);
  double sum_x = 0;
  double sum_y = 0;
  for (const FeatureTrack& track : read) {
    sum_x += track.x;
    sum_y += track.y;
  }
  EXPECT_EQ(sum_x, golden.sum_x);
  EXPECT_EQ(sum_y, golden.sum_y);
}

INSTANTIATE_TEST_SUITE_P(FeatureTracks, FeatureTracksGolden,
                         testing::Values(Golden{1, 11, 98328, 22, 1973, 972},
                                         Golden{2, 4, 26793, 8, 894, 410}));

// Every track after every event.
void expect_the_definition(const FeatureConfig& config, const std::vector<Event>& corners) {
  FeatureTracks tracks(config);
  asap::test::NaiveFeatures naive(config);
  std::vector<FeatureTrack> read;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    ASSERT_EQ(tracks.update(corners[i]), naive.update(corners[i])) << i;
    tracks.read(read);
    ASSERT_EQ(tracks.size(), read.size());
    ASSERT_EQ(read.size(), naive.tracks.size()) << i;
    for (std::size_t j = 0; j < read.size(); ++j) {
      ASSERT_EQ(read[j].id, naive.tracks[j].id) << i;
      ASSERT_EQ(read[j].x, static_cast<double>(naive.tracks[j].x)) << i;
      ASSERT_EQ(read[j].y, static_cast<double>(naive.tracks[j].y)) << i;
      ASSERT_EQ(read[j].size, naive.tracks[j].size) << i;
      ASSERT_EQ(read[j].t_first, naive.tracks[j].t_first) << i;
      ASSERT_EQ(read[j].t_last, naive.tracks[j].t_last) << i;
    }
  }
}

// The wild streams hold edges, noise, borders, equal stamps, silences and jumps of centuries.
TEST(FeatureTracks, AgreeWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto corners = asap::test::wild_stream(wild, 1500);
    for (const int radius : {0, 2, 5, 12}) {
      for (const int window : {1, 2, 20, 200}) {
        for (const int window_us : {0, 100, 10'000}) {
          expect_the_definition({.width = wild.width,
                                 .height = wild.height,
                                 .window = window,
                                 .radius = radius,
                                 .min_neighbours = (radius + window) % 3,
                                 .window_time = microseconds(window_us)},
                                corners);
        }
      }
    }
  }
}

// A small frame full of noise: many candidates at once, so tracks that end in the middle of a list.
TEST(FeatureTracks, AgreeWithTheDefinitionInACrowd) {
  const asap::CounterRandom random(3);
  for (const std::uint64_t ties : {1U, 50U}) {
    std::vector<Event> corners;
    for (std::uint64_t i = 0; i < 6000; ++i) {
      const std::uint64_t bits = random(i);
      corners.push_back({.x = static_cast<std::uint16_t>(bits % 60),
                         .y = static_cast<std::uint16_t>((bits >> 16) % 45),
                         .p = 0,
                         .t = static_cast<std::int64_t>(i / ties)});
    }
    for (const int radius : {3, 7}) {
      expect_the_definition(
          {.width = 60, .height = 45, .window = 1500, .radius = radius, .min_neighbours = 2},
          corners);
    }
  }
}

// A corner that runs along a line, with company: three pixels at each place.
std::vector<Event> runner(double vx, double vy, int steps) {
  std::vector<Event> corners;
  for (int i = 0; i < steps; ++i) {
    const std::int64_t t = 1'000 * i;
    const double x = 100 + vx * static_cast<double>(t) * 1e-6;
    const double y = 100 + vy * static_cast<double>(t) * 1e-6;
    for (const int dx : {-1, 1, 0}) {
      corners.push_back({.x = static_cast<std::uint16_t>(x + dx + 0.5),
                         .y = static_cast<std::uint16_t>(y + 0.5),
                         .p = 1,
                         .t = t});
    }
  }
  return corners;
}

TEST(FeatureTracks, FollowACornerAndItsVelocity) {
  FeatureTracks tracks({.width = 346, .height = 260});
  const auto corners = runner(300, -120, 300);
  for (const Event& corner : corners) tracks.update(corner);
  std::vector<FeatureTrack> read;
  tracks.read(read);
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].id, 0);
  EXPECT_EQ(read[0].x, corners.back().x);
  EXPECT_NEAR(read[0].vx, 300, 15);
  EXPECT_NEAR(read[0].vy, -120, 15);
  EXPECT_GT(read[0].size, 700);
  EXPECT_LE(read[0].t_first, 2'000);
  EXPECT_EQ(read[0].t_last, 299'000);
}

// 300 corners that move together, one of whose events comes after one of each other: the last 200
// hold no neighbours.
std::vector<Event> texture() {
  std::vector<Event> corners;
  for (int i = 0; i < 50; ++i) {
    for (const int dx : {-1, 1, 0}) {
      for (int k = 0; k < 300; ++k) {
        corners.push_back({.x = static_cast<std::uint16_t>(10 + 14 * (k % 20) + i + dx),
                           .y = static_cast<std::uint16_t>(10 + 15 * (k / 20)),
                           .p = 1,
                           .t = 10'000 * i + 3'000 * (dx + 1) + k});
      }
    }
  }
  return corners;
}

TEST(FeatureTracks, TheWindowGrowsWithTheCorners) {
  const auto tracks_at = [](std::int64_t window_us) {
    FeatureTracks tracks({.width = 346, .height = 260, .window_time = microseconds(window_us)});
    for (const Event& corner : texture()) tracks.update(corner);
    std::vector<FeatureTrack> read;
    tracks.read(read);
    return read;
  };
  const auto tracks = tracks_at(FeatureConfig{}.window_time.count());
  EXPECT_EQ(tracks.size(), 300U);
  for (const FeatureTrack& track : tracks) EXPECT_NEAR(track.vx, 100, 30);
  EXPECT_TRUE(tracks_at(0).empty());
}

// A tenth of the corner events, ten times as long apart.
TEST(FeatureTracks, TheWindowStretchesWhereFewEventsAreKept) {
  auto corners = texture();
  for (Event& corner : corners) corner.t *= 10;
  FeatureTracks told({.width = 346, .height = 260});
  told.set_gamma(0.1);
  FeatureTracks other({.width = 346, .height = 260});
  for (const Event& corner : corners) {
    told.update(corner);
    other.update(corner);
  }
  EXPECT_EQ(told.size(), 300U);
  EXPECT_LT(other.size(), 300U);
}

// The fixed memory holds as many as it can, and no more.
TEST(FeatureTracks, AWindowOfAnyLengthHoldsSixteenThousand) {
  const auto tracks_after = [](int lone_corners) {
    FeatureTracks tracks({.width = 30, .height = 30, .window_time = microseconds(1'000'000'000)});
    const auto begin_track = [&](int x) {
      for (const int dx : {-1, 1, 0}) {
        tracks.update({.x = static_cast<std::uint16_t>(x + dx), .y = 2, .p = 0, .t = x});
      }
    };
    tracks.update({.x = 25, .y = 25, .p = 0, .t = 0});
    begin_track(2);
    for (int i = 0; i < lone_corners; ++i) tracks.update({.x = 15, .y = 15, .p = 0, .t = 3});
    begin_track(20);
    return tracks.size();
  };
  EXPECT_EQ(tracks_after(16'000), 2U);
  EXPECT_EQ(tracks_after(17'000), 1U);
}

TEST(FeatureTracks, TheVelocityForgetsByItsMemory) {
  const auto turning = [](std::int64_t velocity_us) {
    FeatureTracks tracks(
        {.width = 346, .height = 260, .velocity_window = microseconds(velocity_us)});
    for (Event corner : runner(300, 0, 300)) tracks.update(corner);
    for (Event corner : runner(-300, 0, 30)) {
      corner.x = static_cast<std::uint16_t>(corner.x + 90);
      corner.t += 300'000;
      tracks.update(corner);
    }
    std::vector<FeatureTrack> read;
    tracks.read(read);
    return read.at(0).vx;
  };
  EXPECT_NEAR(turning(5'000), -300, 40);
  EXPECT_GT(turning(1'000'000), 200);
}

TEST(FeatureTracks, SurviveAnyStampWithFiniteVelocities) {
  constexpr std::int64_t kLow = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kHigh = std::numeric_limits<std::int64_t>::max();
  FeatureTracks tracks({.width = 12, .height = 12, .window = 65535, .min_neighbours = 0});
  const asap::CounterRandom random(9);
  std::vector<FeatureTrack> read;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const std::uint64_t bits = random(i);
    const std::int64_t stamps[] = {kLow, kLow + 1, -1, 0, kHigh - 1, kHigh};
    tracks.update({.x = static_cast<std::uint16_t>(bits % 12),
                   .y = static_cast<std::uint16_t>((bits >> 8) % 12),
                   .p = 0,
                   .t = stamps[(bits >> 16) % (1 + i / 4000)]});
    tracks.read(read);
    for (const FeatureTrack& track : read) {
      ASSERT_TRUE(std::abs(track.vx) < 1e12 && std::abs(track.vy) < 1e12) << i;
    }
  }
  EXPECT_FALSE(read.empty());
}

}  // namespace
}  // namespace asap::feature_tracks_test
