#include "asap/algorithms/e_harris.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "support/errors.hpp"

namespace e_harris_test {
namespace {

using asap::EHarris;
using Labels = std::vector<std::uint8_t>;

TEST(EHarris, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  EHarris({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 724);
  EXPECT_EQ(asap::test::hash_of(labels), 0x6df63b99U);
}

TEST(EHarris, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    for (const double threshold : {8.0, 1.5}) {
      const auto events = asap::test::wild_stream(wild, 6000);
      Labels labels(events.size());
      EHarris({.width = wild.width, .height = wild.height, .threshold = threshold})
          .process(events, labels);
      const asap::test::NaiveEHarris naive(wild.width, wild.height, threshold);
      ASSERT_EQ(labels, naive_labels(naive, events)) << wild.seed;
      if (wild.width == 40) {
        EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 5) << threshold;
      }
    }
  }
}

// Every pixel of a frame in turn: all windows are full, and the threshold lets all of them through.
TEST(EHarris, TestsOneColumnAndOneRowMoreThanTheRings) {
  std::vector<asap::Event> events;
  for (int round = 0; round < 2; ++round) {
    for (std::uint16_t y = 0; y < 12; ++y) {
      for (std::uint16_t x = 0; x < 15; ++x) events.push_back({.x = x, .y = y, .p = 0, .t = 0});
    }
  }
  Labels labels(events.size());
  EHarris({.width = 15, .height = 12, .threshold = -1e9}).process(events, labels);
  for (std::size_t i = 180; i < events.size(); ++i) {
    const auto [x, y, p, t] = events[i];
    EXPECT_EQ(labels[i] != 0, 4 <= x && x <= 11 && 4 <= y && y <= 8) << x << ' ' << y;
  }
}

TEST(EHarris, NamesABadThreshold) {
  EXPECT_EQ(asap::test::error_of([] {
              constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
              EHarris({.width = 10, .height = 10, .threshold = kNan});
            }),
            "threshold = nan: must be finite");
}

}  // namespace
}  // namespace e_harris_test
