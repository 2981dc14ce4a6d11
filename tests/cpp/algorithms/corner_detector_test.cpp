#include "asap/algorithms/corner_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"

namespace asap::corner_detector_test {
namespace {

using std::chrono::microseconds;

using Labels = std::vector<std::uint8_t>;

template <class Detector>
Labels labels_of(Detector detector, const std::vector<Event>& events) {
  Labels labels(events.size(), 7);
  detector.process(events, labels);
  return labels;
}

// The count and the hash are those of the published implementations.
template <class Detector>
void expect_golden(std::size_t corners, std::uint32_t hash) {
  const auto events = test::golden_corner_stream();
  const Labels labels = labels_of(Detector({.width = 346, .height = 260}), events);
  EXPECT_EQ(test::hash_of(labels), hash);
  EXPECT_EQ(Detector({.width = 346, .height = 260}).process(events), corners);
}

TEST(CornerDetector, GoldenVectors) {
  expect_golden<EFast>(694, 0x61ce6dcbU);
  expect_golden<ArcStar>(7354, 0x287f6925U);
  expect_golden<EHarris>(724, 0x6df63b99U);
  expect_golden<FAHarris>(71, 0x9a2dab8eU);
}

// At least `least` corners in every wild stream that has room for them.
template <class Detector, class Naive, class... Parameters>
void expect_the_definition(typename Detector::Config config, std::size_t count, std::int64_t least,
                           Parameters... parameters) {
  for (const auto& wild : test::wild_streams()) {
    const auto events = test::wild_stream(wild, count);
    config.width = wild.width;
    config.height = wild.height;
    const Labels labels = labels_of(Detector(config), events);
    ASSERT_EQ(labels, naive_labels(Naive(wild.width, wild.height, parameters...), events))
        << wild.seed;
    if (wild.width == 40) {
      EXPECT_GE(std::count(labels.begin(), labels.end(), 1), least) << wild.seed;
    }
  }
}

TEST(CornerDetector, AgreesWithTheDefinition) {
  expect_the_definition<EFast, test::NaiveEFast>({.width = 0, .height = 0}, 20'000, 20);
  for (const std::int64_t filter_us : {0, 50'000}) {
    const microseconds filter(filter_us);
    expect_the_definition<ArcStar, test::NaiveArcStar>({.width = 0, .height = 0, .filter = filter},
                                                       20'000, 20, filter_us);
    for (const double threshold : {8.0, -1.0}) {
      expect_the_definition<FAHarris, test::NaiveFAHarris>(
          {.width = 0, .height = 0, .filter = filter, .threshold = threshold}, 20'000,
          threshold < 0 && filter_us == 0 ? 5 : 0, filter_us, threshold);
    }
  }
  for (const double threshold : {8.0, 1.5}) {
    expect_the_definition<EHarris, test::NaiveEHarris>(
        {.width = 0, .height = 0, .threshold = threshold}, 6000, 5, threshold);
  }
}

}  // namespace
}  // namespace asap::corner_detector_test
