#include "study/poisson_arrivals.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "synthetic/scene_checks.hpp"

namespace asap::poisson_arrivals_test {
namespace {

using std::chrono::microseconds;

using test::expect_well_formed;
using test::fingerprint;

std::vector<Event> arrivals(const PoissonArrivalsConfig& config,
                            const std::vector<double>& rates_hz) {
  PoissonArrivals stream{config};
  stream.feed(rates_hz);
  return read_events(stream, SIZE_MAX);
}

std::vector<double> constant(double rate_hz, std::size_t steps) {
  return std::vector<double>(steps, rate_hz);
}

std::vector<double> counts_per(std::int64_t window_us, std::size_t windows, EventSpan events) {
  std::vector<double> counts(windows);
  for (const Event& event : events) ++counts.at(static_cast<std::size_t>(event.t / window_us));
  return counts;
}

double mean(const std::vector<double>& values) {
  return std::reduce(values.begin(), values.end()) / static_cast<double>(values.size());
}

// Mean of (value - mean)(value `lag` later - mean).
double covariance(const std::vector<double>& values, std::size_t lag = 0) {
  const double middle = mean(values);
  double sum = 0.0;
  for (std::size_t i = lag; i < values.size(); ++i) {
    sum += (values[i] - middle) * (values[i - lag] - middle);
  }
  return sum / static_cast<double>(values.size() - lag);
}

TEST(PoissonArrivals, CountsArePoissonWithoutNoise) {
  struct Case {
    double rate_hz;
    std::size_t steps;
  };
  for (const auto& [rate_hz, steps] :
       {Case{1e3, 40'000}, Case{1e5, 20'000}, Case{1e7, 1'000}, Case{6e7, 300}, Case{2e9, 20}}) {
    const auto events = arrivals({.noise = 0.0, .seed = 3}, constant(rate_hz, steps));
    for (const std::int64_t window_us : {PoissonArrivals::kStep_us, std::int64_t{1}}) {
      const std::size_t windows = steps * static_cast<std::size_t>(100 / window_us);
      const auto counts = counts_per(window_us, windows, events);
      const double expected = rate_hz * 1e-6 * static_cast<double>(window_us);
      const auto n = static_cast<double>(windows);
      EXPECT_NEAR(mean(counts), expected, 4.0 * std::sqrt(expected / n)) << rate_hz;
      EXPECT_NEAR(covariance(counts), expected,
                  4.0 * std::sqrt((expected + 2.0 * expected * expected) / n))
          << rate_hz;
      EXPECT_NEAR(covariance(counts, 1), 0.0, 4.0 * expected / std::sqrt(n)) << rate_hz;
    }
  }
}

TEST(PoissonArrivals, NoiseIsALognormalFactorThatRemembersOneMillisecond) {
  constexpr std::size_t kSteps = 50'000;
  constexpr double kPerStep = 200.0;
  for (const double noise : {0.2, 0.4}) {
    const auto counts =
        counts_per(PoissonArrivals::kStep_us, kSteps,
                   arrivals({.noise = noise, .seed = 1}, constant(kPerStep * 1e4, kSteps)));
    // 50 000 steps with a memory of 10 are worth about 5000.
    EXPECT_NEAR(mean(counts), kPerStep, 4.0 * noise * kPerStep / std::sqrt(2500.0));
    const auto log_covariance = [&](std::size_t lag) {
      const double poisson = lag == 0 ? mean(counts) : 0.0;
      const double middle = mean(counts);
      return std::log1p((covariance(counts, lag) - poisson) / (middle * middle));
    };
    EXPECT_NEAR(log_covariance(0), noise * noise, 0.1 * noise * noise);
    EXPECT_NEAR(log_covariance(1) / log_covariance(0), std::exp(-0.1), 0.01);
    EXPECT_NEAR(log_covariance(10) / log_covariance(0), std::exp(-1.0), 0.1);
  }
}

TEST(PoissonArrivals, StampsPixelsAndPolaritiesAreUniform) {
  const PoissonArrivalsConfig config{.width = 20, .height = 16, .noise = 0.0, .seed = 9};
  const auto events = arrivals(config, constant(1e6, 6'400));
  std::vector<double> per_offset(100);
  std::vector<double> per_pixel(20 * 16 * 2);
  for (const Event& event : events) {
    ++per_offset.at(static_cast<std::size_t>(event.t % 100));
    ++per_pixel.at(static_cast<std::size_t>((event.y * 20 + event.x) * 2 + event.p));
  }
  EXPECT_NEAR(covariance(per_offset), mean(per_offset), 5.0 * mean(per_offset) / std::sqrt(50.0));
  EXPECT_NEAR(covariance(per_pixel), mean(per_pixel), 5.0 * mean(per_pixel) / std::sqrt(320.0));
  EXPECT_GT(std::ranges::min(per_pixel), 800.0);     // of 1000
  EXPECT_GT(std::ranges::min(per_offset), 6'000.0);  // of 6400
}

TEST(PoissonArrivals, IsWellFormedAndEndsWithTheDuration) {
  for (const PoissonArrivalsConfig& config :
       {PoissonArrivalsConfig{.duration = microseconds(12'345)},
        PoissonArrivalsConfig{.width = 16,
                              .height = 8192,
                              .duration = microseconds(10'000),
                              .start = microseconds(std::int64_t{1} << 62)},
        PoissonArrivalsConfig{
            .duration = microseconds(10'001), .start = microseconds(-5'000), .noise = 1.0}}) {
    const auto events = arrivals(config, constant(3e7, 1'000));
    expect_well_formed(events, config);
    EXPECT_EQ(events.front().t, config.start.count());
    EXPECT_EQ(events.back().t, config.start.count() + config.duration.count() - 1);
  }
}

TEST(PoissonArrivals, DoesNotDependOnHowTheGridIsCutOrRead) {
  std::vector<double> rates_hz(1'000);
  for (std::size_t i = 0; i < rates_hz.size(); ++i) {
    rates_hz[i] = i % 100 < 20 ? 0.0 : 5e4 * static_cast<double>(i % 300);
  }
  const PoissonArrivalsConfig config{.seed = 4};
  const auto events = arrivals(config, rates_hz);
  ASSERT_GT(events.size(), 100'000U);

  PoissonArrivals stream{config};
  std::vector<Event> joined;
  std::size_t fed = 0;
  for (std::size_t cut = 1; fed < rates_hz.size(); cut = cut * 3 % 101) {
    const std::size_t steps = std::min(cut, rates_hz.size() - fed);
    stream.feed(std::span(rates_hz).subspan(fed, steps));
    fed += steps;
    if (cut % 4 == 0) continue;  // feeds add up
    const auto part = read_events(stream, cut % 3 == 0 ? SIZE_MAX : 500);
    joined.insert(joined.end(), part.begin(), part.end());
  }
  const auto rest = read_events(stream, SIZE_MAX);
  joined.insert(joined.end(), rest.begin(), rest.end());
  EXPECT_EQ(joined, events);
}

// The same on every compiler and machine. A change of the stream changes published figures: say so
// in the changelog.
TEST(PoissonArrivals, FirstEventsAreGolden) {
  std::vector<double> rates_hz(1'000);
  std::iota(rates_hz.begin(), rates_hz.end(), 0.0);
  for (double& rate_hz : rates_hz) rate_hz *= 1e4;
  EXPECT_EQ(fingerprint(arrivals({.seed = 1}, rates_hz)), 13050441055681693374U);
}

TEST(PoissonArrivals, RefusesABadRateAndKeepsTheGridItHas) {
  PoissonArrivals stream{{.seed = 1}};
  stream.feed(constant(1e6, 10));
  for (const double rate_hz : {-1.0, 2.1e9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(stream.feed(std::vector<double>{1e6, rate_hz}), std::invalid_argument);
  }
  EXPECT_EQ(read_events(stream, SIZE_MAX), arrivals({.seed = 1}, constant(1e6, 10)));
}

}  // namespace
}  // namespace asap::poisson_arrivals_test
