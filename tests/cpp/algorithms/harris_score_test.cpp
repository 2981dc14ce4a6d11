#include "algorithms/harris_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "algorithms/naive_corners.hpp"
#include "asap/core/random.hpp"
#include "support/errors.hpp"

namespace harris_score_test {
namespace {

using asap::PatchRows;

double naive_score(const PatchRows& rows) {
  asap::test::Patch patch{};
  for (std::size_t y = 0; y < 9; ++y) {
    for (std::size_t x = 0; x < 9; ++x) patch[y][x] = (rows[y] >> x) & 1;
  }
  return asap::test::naive_harris_score(patch);
}

void expect_naive_score(const PatchRows& rows) {
  const double expected = naive_score(rows);
  ASSERT_NEAR(asap::harris_score(rows), expected, 1e-12 * (1 + std::abs(expected)) * 100);
}

TEST(HarrisScore, IsTheScoreOfTheDefinition) {
  const asap::CounterRandom random(1);
  for (std::uint64_t i = 0; i < 3000; ++i) {
    PatchRows rows;
    for (std::size_t y = 0; y < 9; ++y) rows[y] = random(9 * i + y) % 512;
    expect_naive_score(rows);
  }
}

TEST(HarrisScore, OfASinglePixelAnywhere) {
  for (std::size_t y = 0; y < 9; ++y) {
    for (std::uint32_t x = 0; x < 9; ++x) {
      PatchRows rows{};
      rows[y] = 1U << x;
      expect_naive_score(rows);
    }
  }
}

TEST(HarrisScore, OfTheLargestGradients) {
  PatchRows half;
  half.fill(0b000011111);
  expect_naive_score(half);
  EXPECT_LT(asap::harris_score(half), 0);  // an edge
  PatchRows quarter{};
  for (std::size_t y = 0; y < 5; ++y) quarter[y] = 0b000011111;
  expect_naive_score(quarter);
  EXPECT_GT(asap::harris_score(quarter), 8);  // a corner
  PatchRows all;
  all.fill(0b111111111);
  EXPECT_EQ(asap::harris_score(all), 0);
}

TEST(HarrisScore, NamesABadThreshold) {
  using asap::test::error_of;
  EXPECT_EQ(asap::checked_threshold(-3.5), -3.5);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(error_of([&] { asap::checked_threshold(bad); }).find("threshold = "),
              std::string::npos);
  }
}

}  // namespace
}  // namespace harris_score_test
