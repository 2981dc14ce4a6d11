#include "schemes/bounded_scheme.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/random.hpp"
#include "support/outcomes.hpp"

namespace asap::cost_model_test {
namespace {

using test::package;

constexpr double kAlphaNs = 100e3;
constexpr double kBetaNs = 300.0;
constexpr double kLatencyNs = 10e6;

// About normal, mean 0, variance 1.
double normal(const CounterRandom& random, std::uint64_t index) {
  double sum = 0;
  for (std::uint64_t i = 0; i < 12; ++i) sum += random.uniform(12 * index + i);
  return sum - 6;
}

// The first packages double in size.
double first_size(std::uint64_t index) {
  return index < 15 ? static_cast<double>(2ULL << index) : 1e18;
}

// Overload: the size of a package follows from the model's own estimate, its length is the knee.
double next_size(const CostModel& model, std::uint64_t index, double floor_ns) {
  const double length_ns =
      std::clamp(33 * model.alpha_ns(), std::max(floor_ns, 1.0), kLatencyNs / 2);
  const double size =
      std::max(length_ns - model.alpha_ns(), model.alpha_ns() / 4) / model.beta_ns();
  return std::clamp(std::floor(std::min(size, first_size(index))), 1.0, 1e7);
}

// The true cost of package `index` is factor(index) (alpha + beta n), with 5 % of noise.
double cost_ns(double size, double factor, const CounterRandom& random, std::uint64_t index) {
  return factor * (kAlphaNs + kBetaNs * size) * std::exp(0.05 * normal(random, index));
}

using Factor = std::function<double(std::uint64_t)>;

struct Errors {
  double alpha, beta, prediction;  // relative; the worst of the packages after the warm-up
};

Errors closed_loop(CostModel model, const Factor& factor, std::uint64_t seed,
                   std::uint64_t warm_up = 100, std::uint64_t packages = 2000) {
  const CounterRandom random(seed);
  Errors worst{};
  for (std::uint64_t k = 0; k < packages; ++k) {
    const double f = factor(k);
    const double size = next_size(model, k, kLatencyNs / 10);
    if (k >= warm_up) {
      const double expected_ns = f * (kAlphaNs + kBetaNs * size);
      worst.alpha = std::max(worst.alpha, std::abs(model.alpha_ns() / (f * kAlphaNs) - 1));
      worst.beta = std::max(worst.beta, std::abs(model.beta_ns() / (f * kBetaNs) - 1));
      worst.prediction =
          std::max(worst.prediction, std::abs(model.predict_ns(size) / expected_ns - 1));
    }
    model.update(package(static_cast<std::size_t>(size), cost_ns(size, f, random, k)));
  }
  return worst;
}

TEST(CostModel, OtherSizesAreNotForgotten) {
  CostModel model;
  for (std::size_t k = 0; k < 24; ++k) {
    const std::size_t size = std::size_t{1} << (k % 12);
    model.update(package(size, kAlphaNs + kBetaNs * static_cast<double>(size)));
  }
  const CounterRandom random(4);
  for (std::uint64_t k = 0; k < 5000; ++k) model.update(package(1000, cost_ns(1000, 1, random, k)));
  EXPECT_NEAR(model.alpha_ns(), kAlphaNs, 0.25 * kAlphaNs);
  EXPECT_NEAR(model.beta_ns(), kBetaNs, 0.25 * kBetaNs);
  EXPECT_NEAR(model.predict_ns(1000), 400e3, 20e3);
}

TEST(CostModel, FollowsAStepWithinAFewPackages) {
  for (const double step : {3.0, 1 / 3.0, 30.0, 1 / 30.0}) {
    const Factor factor = [=](std::uint64_t k) { return k < 200 ? 1.0 : step; };
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      EXPECT_LT(closed_loop(CostModel(), factor, seed, 240, 400).prediction, 0.3)
          << step << ", seed " << seed;
    }
  }
}

TEST(CostModel, ClipsOneOutlierAndTheSecondButNotTheThird) {
  const auto trained = [] {
    CostModel model;
    for (std::size_t k = 0; k < 60; ++k) {
      const std::size_t size = std::size_t{1} << (k % 12);
      model.update(package(size, kAlphaNs + kBetaNs * static_cast<double>(size)));
    }
    return model;
  };
  CostModel model = trained();
  const double normal_ns = model.predict_ns(1024);
  model.update(package(1024, 100 * normal_ns));
  model.update(package(1024, 100 * normal_ns));
  EXPECT_LT(model.predict_ns(1024), 1.1 * normal_ns);
  model.update(package(1024, 100 * normal_ns));
  EXPECT_GT(model.predict_ns(1024), 1.2 * normal_ns);

  CostModel turning = trained();  // three on the other side count from the first of them
  for (int k = 0; k < 5; ++k) {
    turning.update(package(1024, k < 2 ? 100 * normal_ns : 0.01 * normal_ns));
  }
  EXPECT_LT(turning.predict_ns(1024), 0.85 * normal_ns);

  CostModel alternating = trained();  // outliers on both sides are no new level
  for (int k = 0; k < 6; ++k) {
    alternating.update(package(1024, k % 2 == 0 ? 100 * normal_ns : 0.01 * normal_ns));
  }
  EXPECT_NEAR(alternating.predict_ns(1024), normal_ns, 0.1 * normal_ns);
}

// What is known of other sizes rises by the least of the three.
TEST(CostModel, ANewLevelIsLearnedAnew) {
  CostModel model;
  for (std::size_t k = 0; k < 60; ++k) {
    const std::size_t size = std::size_t{1} << (k % 12);
    model.update(package(size, kAlphaNs + kBetaNs * static_cast<double>(size)));
  }
  for (int k = 0; k < 10; ++k) model.update(package(1024, 1.2 * (kAlphaNs + kBetaNs * 1024)));
  const double small_ns = model.predict_ns(1);
  const double normal_ns = model.predict_ns(1024);
  for (const double factor : {5.0, 100.0, 7.0}) model.update(package(1024, factor * normal_ns));
  EXPECT_NEAR(model.predict_ns(1024) / normal_ns, 6, 1);
  EXPECT_NEAR(model.predict_ns(1) / small_ns, 5, 0.7);
  EXPECT_GE(model.sigma(), 0.15);               // as careful as at the start
  model.update(package(1024, 10 * normal_ns));  // and every package is news
  EXPECT_NEAR(model.predict_ns(1024) / normal_ns, 8, 1.5);
}

// The packages grow, so the sizes of before do not come back to tell what they cost now.
TEST(CostModel, AFallOfTheCostIsNotTakenForAFixedCost) {
  for (const double factor : {2.5, 4.6, 100.0}) {
    CostModel model;
    for (std::size_t k = 0; k < 60; ++k) {
      const std::size_t size = std::size_t{1} << (k % 12);
      model.update(package(size, factor * (10e3 + 87e3 * static_cast<double>(size))));
    }
    for (int k = 0; k < 30; ++k) model.update(package(9, factor * (10e3 + 87e3 * 9)));
    for (int k = 0; k < 4; ++k) model.update(package(9, 10e3 + 87e3 * 9));
    for (const std::size_t size : {44u, 60u, 70u, 80u, 50u, 90u}) {
      model.update(package(size, 10e3 + 87e3 * static_cast<double>(size)));
    }
    EXPECT_LT(model.alpha_ns(), 100e3) << factor;
    EXPECT_NEAR(model.beta_ns() / 87e3, 1, 0.05) << factor;
  }
}

// Small packages of a calm scene, after an overload in which alpha was taken too high.
TEST(CostModel, AFallThatTheFixedCostExplainsSaysNothingAboutTheEvents) {
  CostModel model;
  for (std::size_t k = 0; k < 60; ++k) {
    const std::size_t size = std::size_t{1} << (k % 14);
    model.update(package(size, 4 * kAlphaNs + kBetaNs * static_cast<double>(size)));
  }
  const CounterRandom random(3);
  for (std::uint64_t k = 0; k < 300; ++k) {
    const std::size_t size = 40 + random(2 * k) % 60;
    const double mean_ns = kAlphaNs + kBetaNs * static_cast<double>(size);
    model.update(package(size, mean_ns * (1 + 0.1 * normal(random, 1000 + k))));
  }
  EXPECT_NEAR(model.alpha_ns() / kAlphaNs, 1, 0.1);
  EXPECT_NEAR(model.beta_ns() / kBetaNs, 1, 0.25);
}

// In closed loop n falls as beta rises, and c stays: a fixed cost, as it seems. One event tells.
TEST(CostModel, OfANewSizeALowCostIsTheTruth) {
  const auto trained = [] {
    CostModel model;
    for (int k = 0; k < 20; ++k) {
      for (const std::size_t size : {40u, 70u, 150u}) model.update(package(size, 500e3));
    }
    EXPECT_GT(model.alpha_ns(), 400e3);
    return model;
  };
  CostModel cheap = trained();
  cheap.update(package(1, 10e3));
  EXPECT_NEAR(cheap.alpha_ns(), 10e3, 10e3);
  CostModel dear = trained();
  dear.update(package(1, 50e6));
  EXPECT_LT(dear.alpha_ns(), 700e3) << "an outage is clipped";
  CostModel known = trained();
  known.update(package(40, 10e3));
  EXPECT_GT(known.alpha_ns(), 350e3) << "and what is known is";
}

// What has been a fixed cost for long, at that size too, is none any more.
TEST(CostModel, ASingleEventRefutesAFixedCost) {
  const auto trained = [] {
    CostModel model;
    const CounterRandom random(3);
    for (std::uint64_t k = 0; k < 900; ++k) {  // with so much noise that 100 us may be some
      const double noise = std::exp(0.6 * normal(random, k));
      model.update(package(k % 3 == 0 ? 1 : 50 * (k % 3), noise * 500e3));
    }
    EXPECT_NEAR(model.alpha_ns(), 500e3, 200e3);
    return model;
  };
  CostModel one = trained();
  one.update(package(1, 100e3));
  EXPECT_LT(one.undisturbed_alpha_ns(), 150e3);
  CostModel more = trained();
  more.update(package(2, 100e3));
  EXPECT_LT(more.undisturbed_alpha_ns(), 250e3) << "a size that is new";
  CostModel noise = trained();
  noise.update(package(1, 200e3));
  EXPECT_GT(noise.alpha_ns(), 250e3);
  CostModel known = trained();
  known.update(package(50, 100e3));
  EXPECT_GT(known.alpha_ns(), 250e3);
}

TEST(CostModel, NoFixedCostIsLargerThanAPackage) {
  CostModel model;
  for (int k = 0; k < 10; ++k) model.update(package(63, 110e3));
  for (int k = 0; k < 3; ++k)
    model.update(package(220, 1.35e6));  // a new level: 63 may cost 370 us
  for (int k = 0; k < 40; ++k) {
    for (const std::size_t size : {220u, 371u, 596u}) model.update(package(size, 1.4e6));
  }
  EXPECT_GT(model.alpha_ns(), 1e6);
  for (int k = 0; k < 3; ++k) model.update(package(220, 0.42 * 1.4e6));
  EXPECT_GT(model.predict_ns(1000), 0.4e6);
}

TEST(CostModel, UntilItKnowsAllOfTheCostMayBeThatOfTheEvents) {
  CostModel model;
  EXPECT_EQ(model.doubted_event_ns(), std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < 6; ++k) {
    const std::size_t size = std::size_t{4} << k;
    model.update(package(size, kAlphaNs + kBetaNs * static_cast<double>(size)));
    EXPECT_DOUBLE_EQ(model.doubted_event_ns(), kAlphaNs / static_cast<double>(size) + kBetaNs);
  }
  model.update(package(8, kAlphaNs + kBetaNs * 8));  // the first guess is forgotten
  EXPECT_EQ(model.doubted_event_ns(), model.beta_ns());
  for (int k = 0; k < 20; ++k) model.update(package(64, kAlphaNs + kBetaNs * 64));
  for (int k = 0; k < 3; ++k) model.update(package(64, 10 * (kAlphaNs + kBetaNs * 64)));
  EXPECT_DOUBLE_EQ(model.doubted_event_ns(), 10 * (kAlphaNs + kBetaNs * 64) / 64) << "a new level";
}

// No package of n events or more costs more by event than one of n.
TEST(CostModel, TheLargestRecentPackageSaysWhatAnEventCostsAtMost) {
  CostModel model;
  EXPECT_EQ(model.max_event_ns(), std::numeric_limits<double>::infinity());
  const auto cost_by_event = [](double size) { return kAlphaNs / size + kBetaNs; };
  const auto update = [&](std::size_t size) {
    model.update(package(size, kAlphaNs + kBetaNs * static_cast<double>(size)));
  };
  for (const std::size_t size : {1u, 2u, 64u, 2000u}) {
    update(size);
    EXPECT_DOUBLE_EQ(model.max_event_ns(), cost_by_event(static_cast<double>(size)));
  }
  for (int k = 0; k < 100; ++k) update(200);
  EXPECT_DOUBLE_EQ(model.max_event_ns(), cost_by_event(2000)) << "it has seen better";
  for (int k = 0; k < 20; ++k) update(200);  // 0.98^120 of 2000
  EXPECT_DOUBLE_EQ(model.max_event_ns(), cost_by_event(200)) << "but not lately";
  update(3000);
  model.update(package(100, 90e6));
  EXPECT_DOUBLE_EQ(model.max_event_ns(), 9e5) << "or it costs more by now";
  update(50);
  EXPECT_DOUBLE_EQ(model.max_event_ns(), cost_by_event(50)) << "or that was an outage";
}

// ---- how large a package may be that nothing stops ---------------------------------------------

// With one size alone, all of the cost may be that of the events.
TEST(CostModel, ASizeIsSafeIfAllOfTheCostIsThatOfTheEvents) {
  CostModel model;
  EXPECT_EQ(model.safe_size(1e6, 1.0, 1.0), 2.0) << "nothing is known";
  model.update(package(100, 1e6));
  EXPECT_EQ(model.safe_size(10e6, 1.0, 1.0), 1001.0);
  EXPECT_EQ(model.safe_size(10e6, 1.0, 2.0), 501.0) << "events that may take twice as long";
  EXPECT_EQ(model.safe_size(1e3, 1.0, 1.0), 2.0);
}

// Three sizes that cost the same: what is fixed is not charged to the events.
TEST(CostModel, AFixedCostIsNotChargedToTheEvents) {
  CostModel model;
  for (const std::size_t size : {1u, 4u, 16u}) model.update(package(size, 5e6));
  EXPECT_GT(model.safe_size(13e6, 1.0, 1.0), 60.0) << "by events alone, 42";
  EXPECT_LE(model.safe_size(13e6, 1.0, 1.0), 8 * 16.0) << "and never more than eight times";
  EXPECT_LE(model.safe_size(5.2e6, 1.0, 1.0), 24.0) << "three costs say little: noise .15";
  EXPECT_LE(model.safe_size(4e6, 1.0, 1.0), 16.0) << "no room for what is fixed";
}

TEST(CostModel, TheSlopeLimitsASize) {
  CostModel model;
  for (int k = 0; k < 200; ++k) {
    for (const std::size_t size : {10u, 100u, 1000u}) {
      model.update(package(size, 5e6 + 1e3 * static_cast<double>(size)));
    }
  }
  // 6 ms for 1000 events, 1 us for each more, and a standard error of 1 % of that package
  const double exact = 1000 + (7e6 - 6e6) / 1e3;
  EXPECT_LE(model.safe_size(7e6, 1.0, 1.0), exact);
  EXPECT_GE(model.safe_size(7e6, 1.0, 1.0), 0.95 * exact);
  EXPECT_LT(model.safe_size(7e6, 1.1, 1.0), 0.8 * exact) << "caution with what is fixed";
  EXPECT_LT(model.safe_size(7e6, 1.0, 1.5), 0.9 * exact) << "caution with events";
}

// A smaller package that took a little longer is noise; a much dearer one is news.
TEST(CostModel, ASmallPackageThatIsSlowByNoiseResetsNothing) {
  CostModel model;
  for (const std::size_t size : {1u, 100u, 1000u}) model.update(package(size, 5e6));
  const double grown = model.safe_size(13e6, 1.0, 1.0);
  model.update(package(1, 5.5e6));
  EXPECT_GE(model.safe_size(13e6, 1.0, 1.0), 0.9 * grown);
  model.update(package(1, 12e6));
  EXPECT_LE(model.safe_size(13e6, 1.0, 1.0), 8.0);
}

TEST(CostModel, OfAPackageInPartsTheFirstIsASecondSize) {
  CostModel whole({.first_alpha_us = 5});
  CostModel parts({.first_alpha_us = 5});
  const CounterRandom random(5);
  for (std::uint64_t k = 0; k < 200; ++k) {
    const double factor = std::exp(0.2 * normal(random, k));
    const double whole_ns = factor * (kAlphaNs + kBetaNs * 900);
    whole.update(package(900, whole_ns));
    parts.update(test::in_parts(900, 60, factor * kAlphaNs, factor * kBetaNs));
  }
  EXPECT_GT(std::abs(whole.alpha_ns() / kAlphaNs - 1), 0.3) << "one size tells nothing";
  EXPECT_NEAR(parts.alpha_ns() / kAlphaNs, 1, 0.15);
  EXPECT_NEAR(parts.beta_ns() / kBetaNs, 1, 0.15);
  EXPECT_NEAR(parts.sigma(), whole.sigma(), 0.02) << "of packages";
  CostModel same;
  CostModel none;
  for (const std::size_t first : {0u, 900u, 901u}) {
    same.update(test::in_parts(900, first, 1e5, 1e3));
    none.update(package(900, 1e6));
  }
  EXPECT_EQ(same.predict_ns(60), none.predict_ns(60)) << "no part";
}

TEST(CostModel, LearnsTheNoise) {
  for (const double noise : {0.0, 0.05, 0.3}) {
    CostModel model;
    const CounterRandom random(9);
    for (std::uint64_t k = 0; k < 1000; ++k) {
      const std::size_t size = std::size_t{1} << (k % 12);
      const double mean_ns = kAlphaNs + kBetaNs * static_cast<double>(size);
      model.update(package(size, mean_ns * (1 + std::max(-0.9, noise * normal(random, k)))));
    }
    const double mean_error = std::max(0.01, 0.8 * noise);  // E|x| of a normal x
    EXPECT_GT(model.sigma(), 0.7 * mean_error);
    EXPECT_LT(model.sigma(), 1.5 * mean_error);
  }
}

// At constant n the two parameters are not separately observable. An alpha that is too small makes
// the knee small, and the small packages confirm it. What packages of other sizes have shown at
// the start prevents that.
TEST(CostModel, DoesNotRunAwayInClosedLoop) {
  const auto efficiency = [](bool starts_small, std::uint64_t seed) {
    const CounterRandom random(seed);
    CostModel model;
    double events = 0, time_ns = 0;
    for (std::uint64_t k = 0; k < 3000; ++k) {
      const double size = next_size(model, starts_small ? k : k + 1000, 0);
      const double cost = cost_ns(size, 1, random, k);
      model.update(package(static_cast<std::size_t>(size), cost));
      if (k < 1000) continue;
      events += size;
      time_ns += cost;
    }
    return events / time_ns * kBetaNs;  // 1 = no time lost to alpha
  };
  double worst = 1, worst_without = 1;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    worst = std::min(worst, efficiency(true, seed));
    worst_without = std::min(worst_without, efficiency(false, seed));
  }
  EXPECT_GT(worst, 0.95);
  EXPECT_LT(worst_without, 0.5);  // the trap is there
}

TEST(CostModel, NeverNegativeNorNaNWhateverIsFed) {
  const std::vector<double> times = {0, -1, -9e18, 9e18, 1e18, 1, 1e5, 1e5, 1e9};
  const std::vector<std::size_t> sizes = {
      0, 1, 2, 100, 8192, std::size_t{1} << 24, std::numeric_limits<std::size_t>::max()};
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const CounterRandom random(seed);
    CostModel model({.first_alpha_us = seed % 3 == 0 ? 0.001 : 1e9,
                     .first_beta_ns = seed % 2 == 0 ? 0.001 : 1e9});
    const std::uint64_t run = 1 + seed % 40;  // how long the same is fed
    for (std::uint64_t k = 0; k < 1000; ++k) {
      model.update(package(sizes[random(2 * (k / run)) % sizes.size()],
                           times[random(2 * (k / run) + 1) % times.size()]));
      ASSERT_TRUE(std::isfinite(model.alpha_ns()) && model.alpha_ns() > 0) << seed << ", " << k;
      ASSERT_TRUE(std::isfinite(model.beta_ns()) && model.beta_ns() > 0) << seed << ", " << k;
      ASSERT_TRUE(std::isfinite(model.sigma()) && model.sigma() >= 0.01) << seed << ", " << k;
      ASSERT_TRUE(std::isfinite(model.predict_ns(1e18)));
    }
  }
}

TEST(CostModel, WhatIsNoTimeIsNoUpdate) {
  CostModel model;
  model.update(package(100, -1));
  model.update(package(0, 1e5));
  EXPECT_EQ(model.count(), 0u);
  EXPECT_DOUBLE_EQ(model.predict_ns(1000), 150e3);
  model.update(package(100, 0));  // an algorithm that returns at once is one
  EXPECT_EQ(model.count(), 1u);
  EXPECT_LT(model.predict_ns(100), 1000);
}

}  // namespace
}  // namespace asap::cost_model_test
