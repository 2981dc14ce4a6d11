// What every scheme promises, whatever its law: a decision that a packager can follow, about any
// backlog and after any outcome; a reset that leaves nothing behind.
#include "asap/schemes/scheme.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "core/random.hpp"
#include "support/allocation_counter.hpp"
#include "support/fake_backlog.hpp"

namespace asap::scheme_test {
namespace {

constexpr std::int64_t kNow = 1'000'000'000;

template <class Scheme>
class EveryScheme : public testing::Test {};

using Schemes = testing::Types<Asap2020, Asap2022, DeadBeat, Deadline, FixedSize, FixedTime, Greedy,
                               SingleEvent>;
TYPED_TEST_SUITE(EveryScheme, Schemes);

// A hundred decisions about backlogs of any size and age, each after any outcome.
std::vector<double> decisions(Scheme& scheme, std::uint64_t seed) {
  const CounterRandom random(seed);
  std::uint64_t draws = 0;
  const auto power = [&](double decades) {
    return std::pow(10.0, decades * random.uniform(draws++));
  };
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max() / 2;
  const std::int64_t absurd_ns[] = {0, -1, kMax, -kMax};
  std::vector<double> numbers;
  for (int k = 0; k < 100; ++k) {
    std::vector<std::int64_t> times(static_cast<std::size_t>(power(3)));
    const double age_ns = power(11);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(times.size());
      times[i] = kNow - static_cast<std::int64_t>(age_ns * (1 - share));
    }
    const test::FakeBacklog events(std::move(times));
    Backlog backlog = events.at(kNow, random(draws++) % 2 == 0);
    if (k % 16 != 0) backlog.previous_start_ns = kNow - static_cast<std::int64_t>(power(10));
    const Decision decision = scheme.decide(backlog);
    if (decision.takes) {
      EXPECT_GE(decision.raw + decision.stale, 1u) << seed;
      EXPECT_LE(decision.raw + decision.stale, backlog.count);
      EXPECT_TRUE(decision.gamma >= 0.0 && decision.gamma <= 1.0);
      EXPECT_GE(decision.budget_ns, 1);
      EXPECT_TRUE(std::isfinite(decision.event_ns) && decision.event_ns >= 0.0);
      EXPECT_TRUE(std::isfinite(decision.fixed_ns) && decision.fixed_ns >= 0.0);
    } else {
      EXPECT_FALSE(backlog.due);
      EXPECT_TRUE(decision.until_ns > kNow || decision.until_count > backlog.count);
    }
    numbers.push_back(static_cast<double>(decision.raw) * decision.gamma);
    numbers.push_back(static_cast<double>(decision.budget_ns));
    const bool is_absurd = random(draws++) % 4 == 0;
    scheme.observe({.size = static_cast<std::size_t>(power(12)) - 1,
                    .raw = backlog.count,
                    .span_ns = is_absurd ? 0 : static_cast<std::int64_t>(power(9)),
                    .start_ns = kNow,
                    .processing_ns = is_absurd ? absurd_ns[random(draws++) % 4]
                                               : static_cast<std::int64_t>(power(10))});
  }
  return numbers;
}

TYPED_TEST(EveryScheme, DecidesWhatCanBeDoneAndForgetsWithAReset) {
  TypeParam used;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Execution execution = seed % 2 == 0 ? Execution::whole : Execution::anytime;
    TypeParam fresh;
    fresh.reset(execution);
    used.reset(execution);
    ASSERT_EQ(decisions(used, seed), decisions(fresh, seed));
    ASSERT_FALSE(testing::Test::HasFailure()) << seed;
  }
}

TYPED_TEST(EveryScheme, ATakeThatKeptNothingTeachesNothing) {
  TypeParam scheme;
  TypeParam untold;
  for (int k = 0; k < 50; ++k) {
    scheme.observe({.size = 0, .raw = 50, .span_ns = 0, .start_ns = 0, .processing_ns = 0});
  }
  EXPECT_EQ(decisions(scheme, 1), decisions(untold, 1));
}

TYPED_TEST(EveryScheme, WhereverMemoryEndsItHasTakenNothing) {
  EXPECT_GE(test::allocations_until_made([] { return make_scheme<TypeParam>(); }), 1);
}

}  // namespace
}  // namespace asap::scheme_test
