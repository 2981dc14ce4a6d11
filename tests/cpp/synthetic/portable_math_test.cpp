#include "synthetic/portable_math.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace asap::portable_math_test {
namespace {

using synthetic::PoissonTable;

TEST(PortableExp, IsTheExponential) {
  for (double x = -700.0; x <= 700.0; x += 0.37) {
    EXPECT_NEAR(synthetic::portable_exp(x) / std::exp(x), 1.0, 1e-15) << x;
  }
}

TEST(PortableLog, IsTheLogarithm) {
  for (double x = 1e-9; x < 1e9; x *= 1.013) {
    EXPECT_NEAR(synthetic::portable_log(x), std::log(x), 1e-10) << x;
  }
}

TEST(NearNormal, HasMeanZeroAndVarianceOne) {
  constexpr std::uint64_t kDraws = 100'000;
  const CounterRandom random(7);
  double sum = 0.0;
  double squares = 0.0;
  for (std::uint64_t number = 0; number < kDraws; ++number) {
    const double draw = synthetic::near_normal(random, number);
    sum += draw;
    squares += draw * draw;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 0.015);
  EXPECT_NEAR(squares / kDraws, 1.0, 0.02);
}

double probability(double mean, std::size_t number) {
  const auto n = static_cast<double>(number);
  return std::exp(n * std::log(mean) - mean - std::lgamma(n + 1.0));
}

TEST(PoissonTable, EveryNumberHasItsProbability) {
  constexpr int kDraws = 1'000'000;  // evenly spread over [0, 1)
  for (const double mean : {1e-4, 0.3, 1.0, 7.5, 60.0, 255.9, PoissonTable::kMaxMean}) {
    PoissonTable table;
    table.set_mean(mean);
    std::vector<int> counts(512);
    for (int i = 0; i < kDraws; ++i) ++counts.at(table.draw((i + 0.5) / kDraws));
    for (std::size_t number = 0; number < counts.size(); ++number) {
      EXPECT_NEAR(counts[number], probability(mean, number) * kDraws, 1.01)
          << mean << " " << number;
    }
  }
}

TEST(PoissonTable, ReachesFarIntoBothTails) {
  PoissonTable table;
  table.set_mean(PoissonTable::kMaxMean);
  EXPECT_EQ(table.draw(0.0), 0U);
  EXPECT_NEAR(static_cast<double>(table.draw(1e-12)), 256.0 - 7.0 * 16.0, 12.0);
  const std::size_t largest = table.draw(1.0 - 0x1.0p-53);
  EXPECT_GT(largest, 256U + 8U * 16U);
  EXPECT_LT(largest, 256U + 11U * 16U);
}

TEST(PoissonTable, MeanZeroIsNeverMoreThanNone) {
  PoissonTable table;
  EXPECT_EQ(table.draw(1.0 - 0x1.0p-53), 0U);
  table.set_mean(50.0);
  table.set_mean(0.0);
  EXPECT_EQ(table.draw(1.0 - 0x1.0p-53), 0U);
}

}  // namespace
}  // namespace asap::portable_math_test
