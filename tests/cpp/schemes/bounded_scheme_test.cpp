#include "asap/schemes/bounded_scheme.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::bounded_scheme_test {
namespace {

using test::error_of;

struct LawConfig {
  double latency_ms = 10.0;
  double overhead = 0.25;
  double min_interval_ms = 0.0;
  double knee = 0.0;

  static constexpr std::tuple kParameters{
      NamedField{"knee", &LawConfig::knee},
      NamedField{"latency_ms", &LawConfig::latency_ms},
  };
};

// Takes all, in half the bound.
class Law final : public BoundedScheme {
 public:
  explicit Law(LawConfig config = {}, CostModelConfig cost = {})
      : BoundedScheme(config, cost), config_(config) {}

  Decision decide(const Backlog& backlog) noexcept override {
    const Decision decision = Decision::take(backlog.count);
    return is_whole() ? decision : within(0.5 * static_cast<double>(latency_bound_ns()), decision);
  }
  std::string_view name() const noexcept override { return "law"; }
  SchemeParameters parameters() const override { return parameters_in_force(config_); }
  std::uint64_t packages() const noexcept { return packages_; }

 private:
  const LawConfig config_;
};

void observe(Law& law, std::size_t size) {
  law.observe({.size = size,
               .raw = size,
               .span_ns = 0,
               .start_ns = 0,
               .processing_ns = static_cast<std::int64_t>(200'000 + 300 * size)});
}

TEST(BoundedScheme, TellsTheBoundInForceAmongItsParameters) {
  Law law({.latency_ms = 0.0123456, .knee = 2});
  EXPECT_EQ(law.latency_bound_ns(), 12'346);
  EXPECT_EQ(law.parameters(), (SchemeParameters{{"knee", 2.0}, {"latency_ms", 0.0123456}}));
  law.set_latency_bound_ns(20'000'000);
  EXPECT_EQ(law.latency_bound_ns(), 20'000'000);
  EXPECT_EQ(law.parameters(), (SchemeParameters{{"knee", 2.0}, {"latency_ms", 20.0}}));
  law.set_latency_bound_ns(12'346);
  EXPECT_EQ(law.parameters()[1].second, SchemeParameter(0.0123456));
}

TEST(BoundedScheme, LearnsTheCostOfPackagesThatRanAndForgetsItInAReset) {
  Law law({}, {.first_alpha_us = 7, .first_beta_ns = 8});
  EXPECT_DOUBLE_EQ(law.alpha_ns(), 7e3);
  EXPECT_DOUBLE_EQ(law.beta_ns(), 8);
  observe(law, 0);
  EXPECT_EQ(law.packages(), 0u);
  EXPECT_DOUBLE_EQ(law.alpha_ns(), 7e3);
  for (int k = 0; k < 200; ++k) observe(law, std::size_t{100} << (k % 7));
  EXPECT_EQ(law.packages(), 200u);
  EXPECT_NEAR(law.alpha_ns(), 200e3, 2e3);
  EXPECT_NEAR(law.beta_ns(), 300, 3);
  law.reset(Execution::whole);
  EXPECT_EQ(law.packages(), 0u);
  EXPECT_DOUBLE_EQ(law.alpha_ns(), 7e3);
}

TEST(BoundedScheme, PlansAnAnytimePackageWithWhatItLearned) {
  Law law({}, {.first_alpha_us = 7, .first_beta_ns = 8});
  const auto backlog = test::FakeBacklog::of(5);
  EXPECT_EQ(law.decide(backlog.at(0)).budget_ns, kNever);
  law.reset(Execution::anytime);
  const Decision decision = law.decide(backlog.at(0));
  EXPECT_EQ(decision.raw, 5u);
  EXPECT_EQ(decision.budget_ns, 5'000'000);
  EXPECT_DOUBLE_EQ(decision.fixed_ns, 7e3);
  EXPECT_DOUBLE_EQ(decision.event_ns, 8);
  EXPECT_EQ(decision.most_event_ns, std::numeric_limits<double>::infinity());
}

TEST(BoundedScheme, RefusesABadConfigurationByName) {
  const auto error = [](LawConfig config) { return error_of([=] { Law law(config); }); };
  EXPECT_EQ(error({.latency_ms = 0, .overhead = 2, .knee = -1}),
            "latency_ms = 0: must be between 0.01 and 1e7 ms");
  EXPECT_EQ(error({.overhead = 2, .knee = -1}), "overhead = 2: must be between 0 (no limit) and 1");
  EXPECT_EQ(error({.min_interval_ms = -1}), "min_interval_ms = -1: must be between 0 and 1e7 ms");
}

TEST(BoundedScheme, KneeIsOffOrAtLeastOne) {
  for (const double knee : {0.0, 1.0, 33.0, 1e6}) EXPECT_NO_THROW(Law({.knee = knee}));
  const auto error = [](double knee) { return error_of([=] { Law law({.knee = knee}); }); };
  const std::string remedy = ": must be 0 (off) or between 1 and 1e6";
  EXPECT_EQ(error(0.5), "knee = 0.5" + remedy);
  EXPECT_EQ(error(-1), "knee = -1" + remedy);
  EXPECT_EQ(error(2e6), "knee = 2000000" + remedy);
  EXPECT_EQ(error(std::numeric_limits<double>::quiet_NaN()), "knee = nan" + remedy);
}

}  // namespace
}  // namespace asap::bounded_scheme_test
