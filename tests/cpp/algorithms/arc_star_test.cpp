#include "asap/algorithms/arc_star.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "support/errors.hpp"

namespace arc_star_test {
namespace {

using asap::ArcStar;
using Labels = std::vector<std::uint8_t>;

TEST(ArcStar, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  ArcStar({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 7354);
  EXPECT_EQ(asap::test::hash_of(labels), 0x287f6925U);
}

TEST(ArcStar, TheDefinitionTestsAsManyEventsAsTheRelease) {
  asap::test::NaiveArcStar naive(346, 260);
  for (const asap::Event& event : asap::test::golden_corner_stream()) naive.update(event);
  EXPECT_EQ(naive.tested(), 163'776U);
}

TEST(ArcStar, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    for (const std::int64_t filter_us : {0, 50'000}) {
      const auto events = asap::test::wild_stream(wild, 20'000);
      Labels labels(events.size());
      ArcStar({.width = wild.width, .height = wild.height, .filter_us = filter_us})
          .process(events, labels);
      const asap::test::NaiveArcStar naive(wild.width, wild.height, filter_us);
      ASSERT_EQ(labels, naive_labels(naive, events)) << wild.seed;
      if (wild.width == 40) {
        EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 20);
      }
    }
  }
}

TEST(ArcStar, NamesABadFilter) {
  EXPECT_EQ(asap::test::error_of([] { ArcStar({.width = 10, .height = 10, .filter_us = -1}); }),
            "filter_us = -1: must be 0 to 500000000 us");
}

}  // namespace
}  // namespace arc_star_test
