#include "asap/schemes/asap2020.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/random.hpp"
#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::asap2020_test {
namespace {

using test::error_of;
using test::FakeBacklog;

// What the scheme takes now, from as many as it wants.
Decision wish(Asap2020& scheme) {
  const FakeBacklog one({0});
  Backlog backlog = one.at(0);
  const Decision decision = scheme.decide(backlog);
  if (decision.takes) return decision;
  backlog.count = decision.until_count;
  return scheme.decide(backlog);
}

// The pull form of the law, in seconds and straight from the formulas; sizes are whole events.
struct Law {
  double a;
  double epsilon;
  double n_max;
  double n_set;
  double gamma = 1;

  void after_package(double n, double processing_s, double span_s) {
    if (span_s > 0 && n >= 2) {
      const double ratio = processing_s / ((1 - epsilon) * span_s);
      n_set = n * std::fmin(std::fmax(ratio, 0.5), 2);
    } else {
      n_set = 2 * n_set;
    }
    n_set = std::fmin(std::fmax(std::floor(n_set), 1), n_max);
    const double rate = n / std::fmax(span_s, 2e-6);
    gamma = rate > a ? std::fmax(0.02, gamma * a / rate) : std::fmin(1, 1.02 * gamma);
  }
};

TEST(Asap2020, FollowsTheLawOverRandomOutcomes) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(seed);
    Asap2020 scheme({.rate_bound = 2e6, .epsilon = 0.05, .first_size = 700, .max_size = 20'000});
    Law law{.a = 2e6, .epsilon = 0.05, .n_max = 20'000, .n_set = 700};
    for (std::uint64_t k = 0; k < 500; ++k) {
      const auto size = static_cast<std::size_t>(std::pow(10.0, 4.3 * random.uniform(4 * k)));
      const auto span_ns =
          k % 17 == 0
              ? 0
              : static_cast<std::int64_t>(std::pow(10.0, 3 + 5 * random.uniform(4 * k + 1)));
      const auto processing_ns =
          static_cast<std::int64_t>(std::pow(10.0, 3 + 5 * random.uniform(4 * k + 2)));
      scheme.observe({.size = size,
                      .raw = 2 * size,
                      .span_ns = span_ns,
                      .start_ns = 0,
                      .processing_ns = processing_ns});
      law.after_package(static_cast<double>(size), static_cast<double>(processing_ns) * 1e-9,
                        static_cast<double>(span_ns) * 1e-9);
      const Decision decision = wish(scheme);
      ASSERT_TRUE(decision.takes);
      ASSERT_NEAR(decision.keep, law.gamma, 1e-9 * law.gamma);
      // Rounding may differ by one kept event, doubled at most once, and 1 / gamma raw ones for
      // each.
      ASSERT_NEAR(static_cast<double>(decision.raw), law.n_set / law.gamma, 1 + 2 / law.gamma)
          << "package " << k;
    }
  }
}

TEST(Asap2020, SizeFollowsProcessingTimeOverSpan) {
  Asap2020 scheme({.epsilon = 0.0});
  EXPECT_EQ(wish(scheme).raw, 1000u);
  const auto observe = [&](std::size_t size, std::int64_t span_us, std::int64_t processing_us) {
    scheme.observe({.size = size,
                    .raw = size,
                    .span_ns = 1000 * span_us,
                    .start_ns = 0,
                    .processing_ns = 1000 * processing_us});
    return wish(scheme).raw;
  };
  EXPECT_EQ(observe(1000, 1000, 1500), 1500u);  // slower than real time: more at once
  EXPECT_EQ(observe(1500, 1500, 900), 900u);    // faster: sooner
  EXPECT_EQ(observe(900, 900, 900), 900u);
  EXPECT_EQ(observe(900, 900, 90'000), 1800u);  // at most doubled
  EXPECT_EQ(observe(1800, 1800, 1), 900u);      // at most halved
  EXPECT_EQ(observe(10, 10, 10), 10u);          // from the size that it really had
  EXPECT_EQ(observe(10, 0, 10), 20u);           // all on one stamp
}

TEST(Asap2020, GammaFallsAboveTheRateBoundAndRecovers) {
  Asap2020 scheme({.rate_bound = 1e6, .epsilon = 0.0});
  const auto observe_rate = [&](double rate) {
    const double span_ns = 1000 / rate * 1e9;
    scheme.observe({.size = 1000,
                    .raw = 1000,
                    .span_ns = std::llround(span_ns),
                    .start_ns = 0,
                    .processing_ns = std::llround(span_ns)});
    return wish(scheme).keep;
  };
  EXPECT_DOUBLE_EQ(observe_rate(1e6), 1.0);
  EXPECT_DOUBLE_EQ(observe_rate(4e6), 0.25);
  EXPECT_EQ(wish(scheme).raw, 4000u);  // 1000 kept events behind a gamma of 1/4
  EXPECT_DOUBLE_EQ(observe_rate(2e6), 0.125);
  EXPECT_DOUBLE_EQ(observe_rate(1e6), 0.125 * 1.02);
  EXPECT_DOUBLE_EQ(observe_rate(1e9), 0.02);
  for (int i = 0; i < 198; ++i) observe_rate(1e5);
  EXPECT_DOUBLE_EQ(observe_rate(1e5), 1.0);
}

TEST(Asap2020, StaysWithinItsBoundsForAbsurdOutcomes) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max() / 2;
  Asap2020 scheme({.first_size = 100, .max_size = 5000, .min_size = 10});
  const CounterRandom random(1);
  const std::int64_t times[] = {0, 1, -1, kMax, -kMax, 1'000'000};
  const std::size_t sizes[] = {0, 1, 2, 10, std::size_t{1} << 40};
  for (std::uint64_t k = 0; k < 10'000; ++k) {
    const std::uint64_t bits = random(k);
    scheme.observe({.size = sizes[bits % 5],
                    .raw = sizes[(bits >> 8) % 5],
                    .span_ns = std::max<std::int64_t>(times[(bits >> 16) % 6], 0),
                    .start_ns = 0,
                    .processing_ns = times[(bits >> 24) % 6]});
    const Decision decision = wish(scheme);
    ASSERT_GE(decision.keep, 0.02);
    ASSERT_LE(decision.keep, 1.0);
    ASSERT_GE(decision.raw, 10u);
    ASSERT_LE(decision.raw, 5000u * 50);
    ASSERT_GE(static_cast<double>(decision.raw) * decision.keep, 10.0 - 1e-6);
    ASSERT_LE(static_cast<double>(decision.raw - 1) * decision.keep, 5000.0);
  }
}

TEST(Asap2020, WaitsForItsSizeUnlessDue) {
  Asap2020 scheme({.first_size = 3});
  EXPECT_EQ(scheme.decide(FakeBacklog::of(2).at(0)).takes, false);
  EXPECT_EQ(scheme.decide(FakeBacklog::of(2).at(0)).until_count, 3u);
  EXPECT_EQ(scheme.decide(FakeBacklog::of(2).at(0, true)).raw, 2u);
  EXPECT_EQ(scheme.decide(FakeBacklog::of(3).at(0)).raw, 3u);
  EXPECT_EQ(scheme.decide(FakeBacklog::of(9).at(0)).raw, 3u);  // the rest waits
  EXPECT_EQ(scheme.decide(FakeBacklog::of(9).at(0, true)).raw, 3u);
}

TEST(Asap2020, ATakeThatKeptNothingLeavesTheSize) {
  Asap2020 scheme;
  scheme.observe({.size = 0, .raw = 50, .span_ns = 0, .start_ns = 0, .processing_ns = 0});
  EXPECT_EQ(wish(scheme).raw, 1000u);
}

TEST(Asap2020, ResetBringsTheFirstStateBack) {
  Asap2020 scheme({.rate_bound = 1e6, .first_size = 300});
  scheme.observe(
      {.size = 300, .raw = 300, .span_ns = 1000, .start_ns = 0, .processing_ns = 1'000'000});
  EXPECT_NE(wish(scheme).keep, 1.0);
  EXPECT_NE(wish(scheme).raw, 300u);
  scheme.reset(Execution::whole);
  EXPECT_EQ(wish(scheme).keep, 1.0);
  EXPECT_EQ(wish(scheme).raw, 300u);
}

TEST(Asap2020, TellsItsNameAndParameters) {
  EXPECT_EQ(Asap2020().name(), "asap2020");
  EXPECT_EQ(Asap2020().parameters(), (SchemeParameters{{"rate_bound", 5e6},
                                                       {"epsilon", 0.05},
                                                       {"first_size", std::int64_t{1000}},
                                                       {"max_size", std::int64_t{50'000}},
                                                       {"min_size", std::int64_t{1}}}));
}

TEST(Asap2020, RefusesABadConfigurationByName) {
  const auto error = [](Asap2020Config config) {
    return error_of([=] { Asap2020 scheme(config); });
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::string rate = ": must be a positive number of events per second";
  EXPECT_EQ(error({.rate_bound = 0}), "rate_bound = 0" + rate);
  EXPECT_EQ(error({.rate_bound = -1}), "rate_bound = -1" + rate);
  EXPECT_EQ(error({.rate_bound = kNaN}), "rate_bound = nan" + rate);
  EXPECT_EQ(error({.rate_bound = kInfinity}), "rate_bound = inf" + rate);
  EXPECT_EQ(error({.epsilon = 1}), "epsilon = 1: must be at least 0 and below 1");
  EXPECT_EQ(error({.epsilon = -0.1}), "epsilon = -0.1: must be at least 0 and below 1");
  EXPECT_EQ(error({.epsilon = kNaN}), "epsilon = nan: must be at least 0 and below 1");
  EXPECT_EQ(error({.min_size = 0}), "min_size = 0: must be at least 1 event");
  EXPECT_EQ(error({.max_size = 9, .min_size = 10}),
            "max_size = 9: must be at least min_size and at most 2^40 events");
  EXPECT_EQ(error({.max_size = (std::size_t{1} << 40) + 1}),
            "max_size = 1099511627777: must be at least min_size and at most 2^40 events");
  EXPECT_EQ(error({.first_size = 9, .min_size = 10}),
            "first_size = 9: must lie between min_size and max_size");
  EXPECT_EQ(error({.first_size = 60'000}),
            "first_size = 60000: must lie between min_size and max_size");
}

}  // namespace
}  // namespace asap::asap2020_test
