#include "asap/algorithms/e_fast.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"

namespace e_fast_test {
namespace {

using asap::EFast;
using Labels = std::vector<std::uint8_t>;

TEST(EFast, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  EFast({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 694);
  EXPECT_EQ(asap::test::hash_of(labels), 0x61ce6dcbU);
}

TEST(EFast, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 20'000);
    Labels labels(events.size());
    EFast({.width = wild.width, .height = wild.height}).process(events, labels);
    ASSERT_EQ(labels, naive_labels(asap::test::NaiveEFast(wild.width, wild.height), events))
        << wild.seed;
    if (wild.width == 40) {
      EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 20) << wild.seed;
    }
  }
}

}  // namespace
}  // namespace e_fast_test
