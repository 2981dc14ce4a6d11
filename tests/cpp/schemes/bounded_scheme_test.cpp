#include "schemes/bounded_scheme.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/random.hpp"
#include "support/fake_backlog.hpp"
#include "support/times.hpp"

namespace asap::bounded_scheme_test {
namespace {

using namespace std::chrono_literals;

using test::FakeBacklog;

// ---- HoldRule -------------------------------------------------------------------------------

constexpr double kLatencyNs = 10e6;
constexpr std::int64_t kNow = 100'000'000;
constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();

// alpha = 100 us, beta = 300 ns.
CostModel slow_algorithm() { return CostModel({.first_alpha_us = 100, .first_beta_ns = 300}); }

struct Situation {
  std::size_t count = 1;
  std::int64_t age_ns = 0;
  std::int64_t interval_ns = 0;
  bool due = false;
  double caution = 1.0;
};

std::optional<Decision> wait(const HoldRule& rule, Situation situation) {
  const FakeBacklog events = FakeBacklog::of(situation.count);
  Backlog backlog = events.at(kNow, situation.due);
  backlog.oldest_ns = kNow - situation.age_ns;
  backlog.previous_start_ns = kNow - situation.interval_ns;
  return rule.wait(backlog, slow_algorithm(), situation.caution, kLatencyNs);
}

TEST(Hold, NoLongerThanAQuarterOfTheBound) {
  const HoldRule rule(0.001, 0s);
  EXPECT_TRUE(wait(rule, {.age_ns = 2'499'999, .interval_ns = 2'499'999}));
  EXPECT_FALSE(wait(rule, {.interval_ns = 2'500'000}));
}

TEST(Hold, EndsWhenAPackageIsEfficient) {
  const HoldRule rule(0.001, 0s);  // an overhead below 5 %: 19 alpha / beta = 6333.3 events
  const auto waits = wait(rule, {.count = 6333});
  ASSERT_TRUE(waits);
  EXPECT_EQ(waits->until_count, 6334u);
  EXPECT_FALSE(wait(rule, {.count = 6334}));

  // Or it would fill half the bound: 4 (alpha + beta n) = 5 ms at n = 3833.3.
  const auto careful = wait(rule, {.count = 3833, .caution = 4.0});
  ASSERT_TRUE(careful);
  EXPECT_EQ(careful->until_count, 3834u);
  EXPECT_FALSE(wait(rule, {.count = 3834, .caution = 4.0}));
}

TEST(Hold, LimitsTheNumberOfPackages) {
  const HoldRule rule(0, 1ms);
  // However many wait, the interval is kept; nothing but time ends it.
  const auto crowd = wait(rule, {.count = 100'000, .age_ns = 200'000, .interval_ns = 300'000});
  ASSERT_TRUE(crowd);
  EXPECT_EQ(crowd->until_ns, kNow + 700'000);
  EXPECT_EQ(crowd->until_count, kAny);
  EXPECT_FALSE(wait(rule, {.count = 100'000, .interval_ns = 1'000'000}));
  EXPECT_FALSE(wait(rule, {.age_ns = 1'000'000, .interval_ns = 300'000}));
}

// Asked again at the time or the count that it named, it lets go, or waits for something later.
TEST(Hold, EveryWaitEnds) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const CounterRandom random(seed);
    const HoldRule rule(random.uniform(0) < 0.3 ? 0.0 : random.uniform(1),
                        test::ms(random.uniform(2) < 0.3 ? 0.0 : 10 * random.uniform(3)));
    const Situation situation{.count = 1 + random(4) % 10'000,
                              .age_ns = static_cast<std::int64_t>(random(5) % 6'000'000),
                              .interval_ns = static_cast<std::int64_t>(random(6) % 6'000'000),
                              .caution = 1 + random.uniform(7)};
    const auto first = wait(rule, situation);
    if (!first) continue;
    ASSERT_GT(first->until_ns, kNow);
    ASSERT_LE(first->until_ns, kNow + 5'000'000);
    ASSERT_GT(first->until_count, situation.count);
    Situation later = situation;
    later.age_ns += first->until_ns - kNow;
    later.interval_ns += first->until_ns - kNow;
    if (const auto second = wait(rule, later)) {
      later.age_ns += second->until_ns - kNow;
      later.interval_ns += second->until_ns - kNow;
      ASSERT_FALSE(wait(rule, later)) << seed;
    }
    if (first->until_count == kAny) continue;
    Situation fuller = situation;
    fuller.count = first->until_count;
    ASSERT_FALSE(wait(rule, fuller)) << seed;
  }
}

// ---- BoundedScheme --------------------------------------------------------------------------

struct LawConfig {
  std::chrono::nanoseconds latency = kDefaultLatency;
  double overhead = 0.25;
  std::chrono::nanoseconds min_interval{};

  static constexpr std::tuple kParameters{
      NamedField{"overhead", &LawConfig::overhead},
      NamedField{"latency_ms", &LawConfig::latency},
  };
};

// Takes all, in half the bound.
class Law final : public BoundedScheme {
 public:
  explicit Law(LawConfig config = {}) : BoundedScheme(config), config_(config) {}

  Decision decide(const Backlog& backlog) noexcept override {
    const Decision decision = Decision::take(backlog.count);
    return is_whole() ? decision : within(0.5 * static_cast<double>(latency_bound_ns()), decision);
  }
  std::string_view name() const noexcept override { return "law"; }
  SchemeParameters parameters() const override { return parameters_in_force(config_); }

 private:
  const LawConfig config_;
};

TEST(BoundedScheme, TellsTheBoundInForceAmongItsParameters) {
  Law law({.latency = 12'346ns, .overhead = 0.5});
  EXPECT_EQ(law.latency_bound_ns(), 12'346);
  EXPECT_EQ(law.parameters(), (SchemeParameters{{"overhead", 0.5}, {"latency_ms", 0.012346}}));
  law.set_latency_bound_ns(20'000'000);
  EXPECT_EQ(law.latency_bound_ns(), 20'000'000);
  EXPECT_EQ(law.parameters(), (SchemeParameters{{"overhead", 0.5}, {"latency_ms", 20.0}}));
  law.set_latency_bound_ns(12'346);
  EXPECT_EQ(law.parameters()[1].second, SchemeParameter(0.012346));
}

}  // namespace
}  // namespace asap::bounded_scheme_test
