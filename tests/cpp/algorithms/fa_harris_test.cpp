#include "asap/algorithms/fa_harris.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "support/errors.hpp"

namespace fa_harris_test {
namespace {

using asap::FAHarris;
using Labels = std::vector<std::uint8_t>;

TEST(FAHarris, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  FAHarris({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 71);
  EXPECT_EQ(asap::test::hash_of(labels), 0x9a2dab8eU);
}

TEST(FAHarris, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    for (const double threshold : {8.0, -1.0}) {
      for (const std::int64_t filter_us : {0, 50'000}) {
        const auto events = asap::test::wild_stream(wild, 20'000);
        Labels labels(events.size());
        FAHarris({.width = wild.width,
                  .height = wild.height,
                  .filter_us = filter_us,
                  .threshold = threshold})
            .process(events, labels);
        const asap::test::NaiveFAHarris naive(wild.width, wild.height, filter_us, threshold);
        ASSERT_EQ(labels, naive_labels(naive, events)) << wild.seed;
        if (wild.width == 40 && threshold < 0 && filter_us == 0) {
          EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 5);
        }
      }
    }
  }
}

TEST(FAHarris, NamesBadParameters) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { FAHarris({.width = 10, .height = 10, .filter_us = -1}); }),
            "filter_us = -1: must be 0 to 500000000 us");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error_of([] { FAHarris({.width = 10, .height = 10, .threshold = kInfinity}); }),
            "threshold = inf: must be finite");
}

}  // namespace
}  // namespace fa_harris_test
