#include "oracle/oracle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/streams.hpp"

namespace asap::oracle_test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

double bound_of(EventSpan events, const LinearCost& cost, double latency_us,
                Execution execution = Execution::whole) {
  Oracle oracle(cost, latency_us, execution);
  oracle.feed(events);
  return oracle.bound();
}

// ---- all schedules of a few events ----------------------------------------------------------

// A choice of events, cut into packages, served as early as possible; package `patient` waits for
// the first step of the drift.
struct Schedule {
  unsigned kept;  // bit i: event i is not discarded
  unsigned cuts;  // bit i: a package ends with event i
  int patient;
};

int in_time(const test::Events& events, const LinearCost& cost, std::int64_t latency_ns,
            const Schedule& schedule) {
  int count = 0;
  int package = 0;
  std::int64_t free_ns = 0;
  std::vector<std::int64_t> members_ns;
  for (std::size_t i = 0; i < events.size(); ++i) {
    if ((schedule.kept >> i & 1U) != 0) members_ns.push_back(1000 * events[i].t);
    const bool ends = (schedule.cuts >> i & 1U) != 0 || i + 1 == events.size();
    if (!ends || members_ns.empty()) continue;
    std::int64_t start_ns = std::max(free_ns, members_ns.back());
    if (package++ == schedule.patient) start_ns = std::max(start_ns, kMillisecond);
    start_ns = cost.start_ns(start_ns);
    free_ns = cost.done_ns(start_ns, cost.package(0, start_ns).of(members_ns.size()));
    for (const std::int64_t time_ns : members_ns) count += free_ns - time_ns <= latency_ns ? 1 : 0;
    members_ns.clear();
  }
  return count;
}

int best_of_all(const test::Events& events, const LinearCost& cost, double latency_us) {
  const auto latency_ns = std::llround(latency_us * 1e3);
  const unsigned all = (1U << events.size()) - 1;
  const int drifts = cost.config().drift.empty() ? 0 : static_cast<int>(events.size());
  int best = 0;
  for (unsigned kept = 0; kept <= all; ++kept) {
    for (unsigned cuts = kept;; cuts = (cuts - 1) & kept) {  // a package ends with a kept event
      for (int patient = -1; patient < drifts; ++patient) {
        best = std::max(best, in_time(events, cost, latency_ns, {kept, cuts, patient}));
      }
      if (cuts == 0) break;
    }
  }
  return best;
}

// Whole numbers in [low, high], one after the other.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  std::int64_t operator()(std::int64_t low, std::int64_t high) {
    const auto range = static_cast<std::uint64_t>(high - low + 1);
    return low + static_cast<std::int64_t>(random_(count_++) % range);
  }

 private:
  CounterRandom random_;
  std::uint64_t count_ = 0;
};

test::Events few_events(Dice& dice, std::int64_t unit_us, std::int64_t first_us, std::int64_t max) {
  std::vector<std::int64_t> stamps_us;
  const std::int64_t count = dice(1, max);
  const std::int64_t last = dice(0, 20);
  for (std::int64_t i = 0; i < count; ++i) stamps_us.push_back(first_us + unit_us * dice(0, last));
  std::sort(stamps_us.begin(), stamps_us.end());
  return test::at_times(stamps_us);
}

std::vector<Outage> few_outages(Dice& dice, std::int64_t unit_us, std::int64_t first_us) {
  std::vector<Outage> outages;
  std::int64_t free_us = first_us;
  for (std::int64_t i = dice(0, 3); i > 0; --i) {
    const std::int64_t begin_us = free_us + unit_us * dice(0, 10);
    free_us = begin_us + unit_us * dice(1, 8);
    outages.push_back({1000 * begin_us, 1000 * free_us});
  }
  return outages;
}

TEST(Oracle, NoScheduleFinishesMoreInTime) {
  Dice dice(1);
  int at_the_bound = 0;
  for (int round = 0; round < 400; ++round) {
    const test::Events events = few_events(dice, 2, 0, 7);
    const LinearCost cost({.alpha_us = static_cast<double>(dice(0, 9)),
                           .beta_ns = 500.0 * static_cast<double>(dice(1, 12)),
                           .outages = few_outages(dice, 2, 0)});
    const auto latency_us = static_cast<double>(dice(10, 24));
    const int best = best_of_all(events, cost, latency_us);
    const double bound = bound_of(events, cost, latency_us);
    ASSERT_GE(bound + 1e-9, best) << "round " << round;
    at_the_bound += best == static_cast<int>(bound + 1e-9) ? 1 : 0;
  }
  EXPECT_GT(at_the_bound, 150);
}

TEST(Oracle, NoScheduleFinishesMoreInTimeWhenEventsGetCheaper) {
  Dice dice(2);
  for (int round = 0; round < 100; ++round) {
    const test::Events events = few_events(dice, 1, 985, 6);
    const LinearCost cost({.alpha_us = static_cast<double>(dice(0, 9)),
                           .beta_ns = 500.0 * static_cast<double>(dice(1, 6)),
                           .drift = {static_cast<double>(dice(1, 6)), 1.0},
                           .outages = few_outages(dice, 1, 985)});
    const auto latency_us = static_cast<double>(dice(10, 24));
    ASSERT_GE(bound_of(events, cost, latency_us) + 1e-9, best_of_all(events, cost, latency_us))
        << "round " << round;
  }
}

// Without a fixed cost, and where all times are multiples of beta, fluid buys nothing.
TEST(Oracle, IsTheBestScheduleOfUnitJobs) {
  Dice dice(3);
  int discarded = 0;
  for (int round = 0; round < 300; ++round) {
    const std::int64_t unit_us = dice(1, 4);
    const test::Events events = few_events(dice, unit_us, 40, 8);
    const LinearCost cost({.alpha_us = 0,
                           .beta_ns = 1000.0 * static_cast<double>(5 * unit_us),
                           .outages = few_outages(dice, 5 * unit_us, 0)});
    test::Events spread = events;
    for (Event& event : spread) event.t = 5 * (event.t / 5 / unit_us) * unit_us;
    const auto latency_us = static_cast<double>(5 * unit_us * dice(2, 4));
    const int best = best_of_all(spread, cost, latency_us);
    ASSERT_NEAR(bound_of(spread, cost, latency_us), best, 1e-9) << "round " << round;
    discarded += best < static_cast<int>(events.size()) ? 1 : 0;
  }
  EXPECT_GT(discarded, 100);
}

// ---- theory ---------------------------------------------------------------------------------

TEST(Oracle, T7_ConstantOverload) {
  const test::Events events = test::evenly_spaced(1'000'000, 1);
  for (const double rho : {1.2, 3.0, 10.0}) {
    const LinearCost cost({.alpha_us = 100, .beta_ns = 1000 * rho});
    const double fraction = bound_of(events, cost, 10'000) / 1e6;
    EXPECT_NEAR(fraction, (1 - 100.0 / 10'000) / rho * (1.0 + 0.01), 1e-6) << rho;
  }
}

TEST(Oracle, NoScheduleFinishesMoreInTimeWhereAPackageTakesExactlyTheBound) {
  Dice dice(4);
  for (int round = 0; round < 100; ++round) {
    const test::Events events = few_events(dice, 4, 0, 6);
    const auto latency_us = static_cast<double>(dice(10, 24));
    const LinearCost cost(
        {.alpha_us = latency_us, .beta_ns = 0, .outages = few_outages(dice, 2, 0)});
    ASSERT_GE(bound_of(events, cost, latency_us), best_of_all(events, cost, latency_us))
        << "round " << round;
  }
  const test::Events burst = test::evenly_spaced(8, 0);
  EXPECT_EQ(bound_of(burst, LinearCost({.alpha_us = 10, .beta_ns = 0}), 10), 8.0);
}

TEST(Oracle, OnlyAnytimeExecutionUsesCheapPackages) {
  const test::Events events = test::evenly_spaced(100'000, 1);
  const LinearCost noisy({.alpha_us = 100, .beta_ns = 3000, .noise = 0.5});
  const LinearCost mean({.alpha_us = 100, .beta_ns = 3000});
  const LinearCost lucky({.alpha_us = 100, .beta_ns = 3000 * std::exp(-0.25)});
  EXPECT_EQ(bound_of(events, noisy, 10'000, Execution::whole), bound_of(events, mean, 10'000));
  EXPECT_NEAR(bound_of(events, noisy, 10'000, Execution::anytime), bound_of(events, lucky, 10'000),
              1e-6);
  EXPECT_GT(bound_of(events, lucky, 10'000), 1.2 * bound_of(events, mean, 10'000));
}

TEST(Oracle, EventsThatCostNothingStillWaitForTheEndOfAnOutage) {
  const test::Events events = test::evenly_spaced(2000, 1);  // 0 .. 1999 us
  const LinearCost cost({.beta_ns = 0, .outages = {{500'000, 1'500'000}}});
  // Lost: those of the first 800 us of the outage.
  EXPECT_EQ(bound_of(events, cost, 200), 2000 - 801);
}

TEST(Oracle, AFreeMillisecondEmptiesTheQueue) {
  const LinearCost cost({.alpha_us = 0, .beta_ns = 10'000, .drift = {1, 0, 1}});
  // 100 us serve 10 events, and what reaches the free millisecond is admitted whole.
  const auto burst = [&](std::int64_t at_us) {
    return bound_of(test::evenly_spaced(1000, 0, at_us), cost, 100);
  };
  EXPECT_DOUBLE_EQ(burst(0), 10);
  EXPECT_DOUBLE_EQ(burst(900), 10);  // the deadline is its first moment
  EXPECT_DOUBLE_EQ(burst(901), 1000);
  EXPECT_DOUBLE_EQ(burst(1999), 1000);
  EXPECT_DOUBLE_EQ(burst(2000), 10);
  test::Events two = test::evenly_spaced(1000, 0, 950);
  const test::Events after = test::evenly_spaced(1000, 0, 2000);
  two.insert(two.end(), after.begin(), after.end());
  EXPECT_DOUBLE_EQ(bound_of(two, cost, 100), 1010);
}

// ---- streams --------------------------------------------------------------------------------

TEST(Oracle, DoesNotDependOnTheCuts) {
  const LinearCost cost({.beta_ns = 20'000,
                         .drift = {1.0, 0.7, 1.3, 0.4},
                         .outages = {{700'000, 1'900'000}, {1'900'000, 2'100'000}}});
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const test::Events events = test::random_stream(seed, 20'000);
    const EventSpan all(events);
    Dice dice(seed);
    Oracle oracle(cost, 3000, Execution::anytime);
    for (std::size_t at = 0; at < events.size();) {
      const std::size_t size = std::min(static_cast<std::size_t>(dice(0, 700)), events.size() - at);
      oracle.feed(all.subspan(at, size));
      at += size;
    }
    EXPECT_EQ(oracle.bound(), bound_of(events, cost, 3000, Execution::anytime));
  }
}

TEST(Oracle, RunTimeBeginsAtTheWholeSecondBeforeTheFirstStamp) {
  const LinearCost cost({.alpha_us = 0, .beta_ns = 10'000, .drift = {1, 2, 4}});
  for (const std::int64_t second_us : {-3'000'000LL, 0LL, 1'700'000'000'000'000LL}) {
    for (const std::int64_t ms : {0, 1, 2, 700}) {
      const test::Events burst = test::evenly_spaced(100, 0, second_us + 1000 * ms);
      const double factor = ms == 0 ? 1 : ms == 1 ? 2 : 4;
      EXPECT_NEAR(bound_of(burst, cost, 400), 40 / factor, 1e-6) << second_us << " + " << ms;
    }
  }
  EXPECT_NEAR(bound_of(test::at_times({0, 5'000'000, 5'000'000}), cost, 50), 1 + 50.0 / 40, 1e-6);
}

}  // namespace
}  // namespace asap::oracle_test
