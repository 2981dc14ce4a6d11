#include "study/clairvoyant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "asap/core/time.hpp"
#include "core/random.hpp"
#include "oracle/oracle.hpp"
#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap::clairvoyant_test {
namespace {

// ---- clairvoyant_latency_ns -----------------------------------------------------------------

constexpr std::int64_t kMillisecond = 1'000'000;

// The least maximum latency over all ways to cut the events into packages (a boundary may come
// before event i if `may_cut(i)`), and to wait for a later step of the drift.
class EveryCut {
 public:
  EveryCut(const test::Events& events, const LinearCost& cost, bool parts_equal_stamps)
      : events_(events), cost_(cost), parts_equal_stamps_(parts_equal_stamps) {}

  std::int64_t latency_ns(std::size_t first = 0, std::int64_t free_ns = 0) const {
    if (first == events_.size()) return 0;
    std::int64_t best_ns = kNever;
    for (std::size_t end = first + 1; end <= events_.size(); ++end) {
      if (!may_cut(end)) continue;
      const std::int64_t ready_ns = std::max(free_ns, 1000 * events_[end - 1].t);
      for (const std::int64_t start_ns : starts_from(ready_ns)) {
        const double work_ns = cost_.package(0, start_ns).of(end - first);
        const std::int64_t done_ns = cost_.done_ns(start_ns, work_ns);
        const std::int64_t own_ns = done_ns - 1000 * events_[first].t;
        best_ns = std::min(best_ns, std::max(own_ns, latency_ns(end, done_ns)));
      }
    }
    return best_ns;
  }

 private:
  bool may_cut(std::size_t i) const {
    return parts_equal_stamps_ || i == events_.size() || events_[i].t != events_[i - 1].t;
  }

  std::vector<std::int64_t> starts_from(std::int64_t ready_ns) const {
    std::vector<std::int64_t> starts{cost_.start_ns(ready_ns)};
    const auto steps = static_cast<std::int64_t>(cost_.config().drift.size());
    for (std::int64_t step = 1; step < steps; ++step) {
      if (step * kMillisecond > ready_ns) starts.push_back(cost_.start_ns(step * kMillisecond));
    }
    return starts;
  }

  const test::Events& events_;
  const LinearCost& cost_;
  bool parts_equal_stamps_;
};

// Events within `range_us`, some on equal stamps; costs of the order of their distances.
struct Case {
  test::Events events;
  LinearCostConfig config;
};

Case random_case(std::uint64_t seed, std::size_t max, std::int64_t range_us) {
  const CounterRandom random(seed);
  const std::size_t count = 1 + random(0) % max;
  std::vector<std::int64_t> stamps_us;
  for (std::size_t i = 0; i < count; ++i) {
    const auto slot = static_cast<std::int64_t>(random(10 + i) % 40);
    stamps_us.push_back(slot * range_us / 40);
  }
  std::sort(stamps_us.begin(), stamps_us.end());
  const double distance_us = static_cast<double>(range_us) / static_cast<double>(count);
  Case result{test::at_times(stamps_us),
              {.alpha_us = std::floor(distance_us * random.uniform(1)),
               .beta_ns = std::floor(1000 * distance_us * random.uniform(2))}};
  return result;
}

std::vector<Outage> random_outages(std::uint64_t seed, std::int64_t range_us) {
  const CounterRandom random(1000 + seed);
  std::vector<Outage> outages;
  std::int64_t free_ns = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto length = static_cast<std::uint64_t>(250 * range_us);
    const std::int64_t begin_ns = free_ns + 1 + static_cast<std::int64_t>(random(2 * i) % length);
    free_ns = begin_ns + 1 + static_cast<std::int64_t>(random(2 * i + 1) % length);
    outages.push_back({begin_ns, free_ns});
  }
  return outages;
}

// ---- all cuts of a few events ---------------------------------------------------------------

TEST(Clairvoyant, IsTheBestOfAllCuts) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const auto [events, config] = random_case(seed, 11, 400);
    const LinearCost cost(config);
    ASSERT_EQ(clairvoyant_latency_ns(events, cost, 0), EveryCut(events, cost, true).latency_ns())
        << "seed " << seed;
  }
}

TEST(Clairvoyant, IsTheBestOfAllCutsBetweenDifferentStamps) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    auto [events, config] = random_case(seed, 12, 40);
    const LinearCost cost(config);
    ASSERT_EQ(clairvoyant_latency_ns(events, cost, 1), EveryCut(events, cost, false).latency_ns())
        << "seed " << seed;
  }
}

TEST(Clairvoyant, ForeseesOutages) {
  int lengthened = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    auto [events, config] = random_case(seed, 10, 400);
    const std::int64_t undisturbed_ns = clairvoyant_latency_ns(events, LinearCost(config), 0);
    config.outages = random_outages(seed, 400);
    const LinearCost cost(config);
    const std::int64_t latency_ns = clairvoyant_latency_ns(events, cost, 0);
    ASSERT_EQ(latency_ns, EveryCut(events, cost, true).latency_ns()) << "seed " << seed;
    lengthened += latency_ns > undisturbed_ns ? 1 : 0;
  }
  EXPECT_GT(lengthened, 50);
}

TEST(Clairvoyant, WaitsForACheaperMillisecond) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    auto [events, config] = random_case(seed, 6, 4000);
    const CounterRandom random(seed);
    for (std::uint64_t i = 0; i < 5; ++i) config.drift.push_back(3 * random.uniform(100 + i));
    if (seed % 2 == 0) config.outages = random_outages(seed, 4000);
    const LinearCost cost(config);
    const std::int64_t latency_ns = clairvoyant_latency_ns(events, cost, 0);
    ASSERT_EQ(latency_ns, EveryCut(events, cost, true).latency_ns()) << "seed " << seed;
  }
  const LinearCost dear({.alpha_us = 0, .beta_ns = 1e5, .drift = {100.0, 1.0}});
  EXPECT_EQ(clairvoyant_latency_ns(test::at_times({500}), dear, 0), 600'000);
}

// ---- simple streams -------------------------------------------------------------------------

// T4: at a constant rate intervals of T* = alpha/(1 - rho) are the best, and their latency is 2 T*.
TEST(Clairvoyant, T4_ConstantRate) {
  for (const double rho : {0.2, 0.5, 0.8}) {
    const LinearCost cost({.alpha_us = 30, .beta_ns = 1000 * rho});
    const double expected_ns = 2 * 30e3 / (1 - rho);
    const auto latency_ns =
        static_cast<double>(clairvoyant_latency_ns(test::evenly_spaced(5000, 1), cost, 1));
    EXPECT_NEAR(latency_ns, expected_ns, 0.03 * expected_ns) << rho;
  }
}

TEST(Clairvoyant, TheWidthOfABinCounts) {
  const test::Events events = test::at_times({1'000'000, 1'000'004, 1'000'005, 1'000'009});
  const LinearCost cost({.alpha_us = 0, .beta_ns = 1000});
  EXPECT_EQ(clairvoyant_latency_ns(events, cost, 1), 1000);
  EXPECT_EQ(clairvoyant_latency_ns(events, cost, 5), 6000);
  EXPECT_EQ(clairvoyant_latency_ns(events, cost, 4.5),
            6000);  // 0 4 | 5 | 9, by stamps: 0 4 | 5 8.9
  EXPECT_EQ(clairvoyant_latency_ns(events, cost), 13'000);
}

// ---- refusals -------------------------------------------------------------------------------

TEST(Clairvoyant, RefusesNoiseAndBinsOutOfRange) {
  const auto error = [](double noise, double bin_us) {
    return test::error_of(
        [=] { clairvoyant_latency_ns(test::at_times({1}), LinearCost({.noise = noise}), bin_us); });
  };
  EXPECT_EQ(error(0.05, 10),
            "noise = 0.05: must be 0: the draws of a noisy cost cannot be foreseen");
  EXPECT_EQ(error(0, -1), "bin_us = -1: must be between 0 and 1e6 us");
  EXPECT_EQ(error(0, 2e6), "bin_us = 2000000: must be between 0 and 1e6 us");
  EXPECT_EQ(error(0, std::numeric_limits<double>::quiet_NaN()),
            "bin_us = nan: must be between 0 and 1e6 us");
}

// ---- exact_clairvoyant ----------------------------------------------------------------------

using test::error_of;
using test::Events;

// Every event is discarded, joins the open package, or opens the next one.
class EveryChoice {
 public:
  EveryChoice(const Events& events, const LinearCost& cost, double latency_us)
      : events_(events), cost_(cost), latency_ns_(1e3 * latency_us) {}

  int max() const { return max(0, -1e18, {}); }

 private:
  struct Package {
    int size = 0;
    double first_ns = 0;
    double last_ns = 0;
  };
  static constexpr int kImpossible = -1000;

  int max(std::size_t next, double free_ns, Package open) const {
    if (next == events_.size()) return closed(open, free_ns) ? open.size : kImpossible;
    const double time_ns = 1e3 * static_cast<double>(events_[next].t);
    int best = max(next + 1, free_ns, open);
    if (open.size > 0) {
      const Package longer{open.size + 1, open.first_ns, time_ns};
      best = std::max(best, max(next + 1, free_ns, longer));
    }
    if (closed(open, free_ns)) {
      best = std::max(best, open.size + max(next + 1, free_ns, {1, time_ns, time_ns}));
    }
    return best;
  }

  // Whether the package is in time; then `free_ns` is when it ends.
  bool closed(const Package& open, double& free_ns) const {
    if (open.size == 0) return true;
    free_ns = std::max(free_ns, open.last_ns) +
              std::round(1e3 * cost_.config().alpha_us + cost_.config().beta_ns * open.size);
    return free_ns <= open.first_ns + latency_ns_;
  }

  const Events& events_;
  const LinearCost& cost_;
  double latency_ns_;
};

// The same programme over the whole table: every number of events, every block.
std::uint64_t by_the_whole_table(const Events& events, const LinearCost& cost, double latency_us) {
  const std::size_t count = events.size();
  std::vector<std::vector<double>> end_ns(count + 1, std::vector<double>(count + 1, 1e18));
  end_ns[0][0] = 0;
  for (std::size_t e = 1; e <= count; ++e) {
    const double newest_ns = 1e3 * static_cast<double>(events[e - 1].t);
    end_ns[e] = end_ns[e - 1];
    for (std::size_t size = 1; size <= e; ++size) {
      const double first_ns = 1e3 * static_cast<double>(events[e - size].t);
      const double work_ns = std::round(1e3 * cost.config().alpha_us +
                                        cost.config().beta_ns * static_cast<double>(size));
      for (std::size_t k = 0; k + size <= e; ++k) {
        const double end = std::max(end_ns[e - size][k], newest_ns) + work_ns;
        if (end > first_ns + 1e3 * latency_us) continue;
        end_ns[e][k + size] = std::min(end_ns[e][k + size], end);
      }
    }
  }
  std::size_t max = count;
  while (end_ns[count][max] > 1e17) --max;
  return max;
}

Events at(const std::vector<std::int64_t>& stamps_us) {
  Events events;
  for (const std::int64_t t : stamps_us) events.push_back({.x = 0, .y = 0, .p = 0, .t = t});
  return events;
}

// Gaps of an exponential distribution around this mean.
Events poisson(std::size_t count, double mean_us, std::uint64_t seed) {
  const CounterRandom random(seed);
  Events events;
  double time_us = 0;
  for (std::size_t i = 0; i < count; ++i) {
    time_us -= mean_us * std::log((static_cast<double>(random(i) >> 11) + 0.5) * 0x1.0p-53);
    events.push_back({.x = 0, .y = 0, .p = 0, .t = static_cast<std::int64_t>(time_us)});
  }
  return events;
}

TEST(ExactClairvoyant, IsTheBestOfAllSubsetsAndCuts) {
  int below_the_fluid_bound = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const CounterRandom random(seed);
    const std::size_t count = 2 + random(0) % 8;
    const Events events = poisson(count, static_cast<double>(1 + random(1) % 60), seed);
    const LinearCost cost{{.alpha_us = static_cast<double>(1 + random(2) % 60),
                           .beta_ns = static_cast<double>(random(3) % 40'000)}};
    const double latency_us = static_cast<double>(20 + random(4) % 250);
    const auto wanted = static_cast<std::uint64_t>(EveryChoice(events, cost, latency_us).max());
    const std::uint64_t found = exact_clairvoyant(events, cost, latency_us);
    ASSERT_EQ(found, wanted) << "seed " << seed;
    Oracle fluid(cost, latency_us, Execution::whole);
    fluid.feed(events);
    ASSERT_LE(static_cast<double>(found), fluid.bound() + 1e-9) << "seed " << seed;
    below_the_fluid_bound += static_cast<double>(found) < fluid.bound() - 0.5 ? 1 : 0;
  }
  EXPECT_GT(below_the_fluid_bound, 40);
}

TEST(ExactClairvoyant, LeavesNothingOutThatCouldWin) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const CounterRandom random(seed);
    Events events = poisson(150, 1e3 / static_cast<double>(5 + random(0) % 40), seed);
    std::int64_t burst_us = 0;  // and silences, so that the backlog rises and falls
    for (std::size_t i = 0; i < events.size(); ++i) {
      if (random(10 + i) % 20 == 0) burst_us += static_cast<std::int64_t>(random(1000 + i) % 900);
      events[i].t += burst_us;
    }
    const double alpha_us = static_cast<double>(20 + random(1) % 300);
    const double load = 0.5 + 0.01 * static_cast<double>(random(2) % 250);
    const double per_bound = static_cast<double>(5 + random(0) % 40);
    const LinearCost cost{
        {.alpha_us = alpha_us, .beta_ns = load * (1e3 - alpha_us) / per_bound * 1e3}};
    ASSERT_EQ(exact_clairvoyant(events, cost, 1e3), by_the_whole_table(events, cost, 1e3))
        << "seed " << seed;
  }
}

TEST(ExactClairvoyant, RefusesWhatItDoesNotKnowAndWhatIsTooMuch) {
  const auto refusal = [](LinearCostConfig config, const Events& events, double latency_us) {
    return error_of([&] { exact_clairvoyant(events, LinearCost(config), latency_us); });
  };
  EXPECT_EQ(refusal({.drift = {1.0, 2.0}}, at({1}), 10).substr(0, 10), "drift = 2:");
  EXPECT_EQ(refusal({.outages = {{1, 2}}}, at({1}), 10).substr(0, 12), "outages = 1:");
  EXPECT_EQ(refusal({}, at({1}), 0).substr(0, 15), "latency_us = 0:");
  const Events flood(400'000, Event{.x = 0, .y = 0, .p = 0, .t = 7});
  const std::string too_many = refusal({.alpha_us = 1, .beta_ns = 0.01}, flood, 1e4);
  EXPECT_EQ(too_many.substr(0, 16), "events = 400000:");
  const std::size_t given = too_many.find("the first ");
  ASSERT_NE(given, std::string::npos) << too_many;
  const std::size_t fits = std::stoul(too_many.substr(given + 10));
  EXPECT_GT(fits, 1'000U);
  EXPECT_LT(fits, flood.size());
}

}  // namespace
}  // namespace asap::clairvoyant_test
