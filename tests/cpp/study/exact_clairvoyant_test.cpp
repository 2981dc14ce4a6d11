#include "study/exact_clairvoyant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "asap/core/random.hpp"
#include "study/oracle.hpp"
#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap::exact_clairvoyant_test {
namespace {

using test::error_of;
using test::Events;

// Every event is discarded, joins the open package, or opens the next one.
class BruteForce {
 public:
  BruteForce(const Events& events, const LinearCost& cost, double latency_us)
      : events_(events), cost_(cost), latency_ns_(1e3 * latency_us) {}

  int most() const { return most(0, -1e18, {}); }

 private:
  struct Package {
    int size = 0;
    double first_ns = 0;
    double last_ns = 0;
  };
  static constexpr int kImpossible = -1000;

  int most(std::size_t next, double free_ns, Package open) const {
    if (next == events_.size()) return closed(open, free_ns) ? open.size : kImpossible;
    const double time_ns = 1e3 * static_cast<double>(events_[next].t);
    int best = most(next + 1, free_ns, open);
    if (open.size > 0) {
      const Package longer{open.size + 1, open.first_ns, time_ns};
      best = std::max(best, most(next + 1, free_ns, longer));
    }
    if (closed(open, free_ns)) {
      best = std::max(best, open.size + most(next + 1, free_ns, {1, time_ns, time_ns}));
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
  std::size_t most = count;
  while (end_ns[count][most] > 1e17) --most;
  return most;
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
    const auto wanted = static_cast<std::uint64_t>(BruteForce(events, cost, latency_us).most());
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

TEST(ExactClairvoyant, TheEndOfTheBoundIsInTime) {
  const LinearCost cost{{.alpha_us = 100, .beta_ns = 10'000}};
  EXPECT_EQ(exact_clairvoyant(at({5}), cost, 110), 1U);
  EXPECT_EQ(exact_clairvoyant(at({5}), cost, 109.999), 0U);
  EXPECT_EQ(exact_clairvoyant(at({5, 5}), cost, 120), 2U);
  EXPECT_EQ(exact_clairvoyant(at({5, 5}), cost, 119.999), 1U);
}

TEST(ExactClairvoyant, LiesBelowTheFluidBoundWherePackagesAreFew) {
  const Events events = poisson(20'000, 1e4 / 300, 1);
  const double alpha_us = 2'000;  // a fifth of the bound; 1.1 times too many events
  const LinearCost cost{{.alpha_us = alpha_us, .beta_ns = 1.1 * 8e6 / 300}};
  Oracle fluid(cost, 1e4, Execution::whole);
  fluid.feed(events);
  const double share = static_cast<double>(exact_clairvoyant(events, cost, 1e4)) / fluid.bound();
  EXPECT_NEAR(share, 0.81, 0.03);
}

TEST(ExactClairvoyant, StampsThatGoBackCountAsTheOneBefore) {
  const LinearCost cost{{.alpha_us = 10, .beta_ns = 1'000}};
  EXPECT_EQ(exact_clairvoyant(at({100, 40, 130}), cost, 20),
            exact_clairvoyant(at({100, 100, 130}), cost, 20));
}

TEST(ExactClairvoyant, NothingAndWhatIsNeverInTime) {
  EXPECT_EQ(exact_clairvoyant({}, LinearCost{}, 10), 0U);
  EXPECT_EQ(exact_clairvoyant(at({1, 2, 3}), LinearCost{{.alpha_us = 50}}, 10), 0U);
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
}  // namespace asap::exact_clairvoyant_test
