#include "asap/schemes/fixed.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::fixed_test {
namespace {

using namespace std::chrono_literals;

// ---- FixedSize ------------------------------------------------------------------------------

using test::FakeBacklog;

TEST(FixedSize, TakesTheOldestAsSoonAsEnoughWait) {
  FixedSize scheme({.size = 3});
  struct Row {
    std::size_t count;
    bool due;
    bool takes;
    std::size_t raw;
  };
  const Row table[] = {{1, false, false, 0}, {2, false, false, 0},  {3, false, true, 3},
                       {4, false, true, 3},  {100, false, true, 3}, {1, true, true, 1},
                       {2, true, true, 2},   {3, true, true, 3},    {100, true, true, 3}};
  for (const Row& row : table) {
    const FakeBacklog backlog = FakeBacklog::of(row.count);
    const Decision decision = scheme.decide(backlog.at(0, row.due));
    EXPECT_EQ(decision.takes, row.takes) << row.count;
    if (row.takes) {
      EXPECT_EQ(decision.raw, row.raw) << row.count;
      EXPECT_EQ(decision.keep, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    } else {
      EXPECT_EQ(decision.until_count, 3u);
      EXPECT_EQ(decision.until_ns, kNever);
    }
  }
}

TEST(FixedSize, TellsItsNameAndParameters) {
  EXPECT_EQ(FixedSize().name(), "fixed_size");
  EXPECT_EQ(FixedSize().parameters(), (SchemeParameters{{"size", std::int64_t{1000}}}));
  EXPECT_EQ(FixedSize({.size = 7}).parameters(), (SchemeParameters{{"size", std::int64_t{7}}}));
  EXPECT_EQ(FixedSize().latency_bound_ns(), 0);
}

TEST(FixedSize, RefusesPackagesOfNothing) {
  EXPECT_EQ(test::error_of([] { FixedSize scheme({.size = 0}); }),
            "size = 0: must be between 1 and 2^40 events");
  // Found by the fuzzer: such a size read -1 among the parameters.
  EXPECT_EQ(test::error_of([] { FixedSize scheme({.size = ~std::size_t{0}}); }),
            "size = 18446744073709551615: must be between 1 and 2^40 events");
}

// ---- FixedTime ------------------------------------------------------------------------------

TEST(FixedTime, WaitsForTheNextMultipleOfThePeriod) {
  FixedTime scheme({.period = 1ms});
  const struct {
    std::int64_t oldest_ns;
    std::int64_t boundary_ns;
  } table[] = {{0, 1'000'000},         {1, 1'000'000},          {999'999, 1'000'000},
               {1'000'000, 2'000'000}, {7'300'000, 8'000'000},  {-1, 0},
               {-1'000'000, 0},        {-1'000'001, -1'000'000}};
  for (const auto& row : table) {
    const FakeBacklog backlog({row.oldest_ns});
    const Decision early = scheme.decide(backlog.at(row.boundary_ns - 1));
    EXPECT_FALSE(early.takes) << row.oldest_ns;
    EXPECT_EQ(early.until_ns, row.boundary_ns) << row.oldest_ns;
    const Decision on_time = scheme.decide(backlog.at(row.boundary_ns));
    EXPECT_TRUE(on_time.takes) << row.oldest_ns;
    EXPECT_EQ(on_time.raw, 1u) << row.oldest_ns;
  }
}

TEST(FixedTime, CutsABacklogWhereItWouldHaveBeenCutOnArrival) {
  FixedTime scheme({.period = 1ms});
  const FakeBacklog backlog({100, 999'999, 1'000'000, 1'500'000, 5'000'000});
  const Decision decision = scheme.decide(backlog.at(9'000'000));
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.raw, 2u);
  EXPECT_EQ(decision.keep, 1.0);
}

TEST(FixedTime, WhenDueTakesThePartOfThePeriodThatIsThere) {
  FixedTime scheme({.period = 20ms});
  const FakeBacklog backlog({100, 200, 300});
  EXPECT_FALSE(scheme.decide(backlog.at(1000)).takes);
  const Decision decision = scheme.decide(backlog.at(1000, true));
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.raw, 3u);
}

TEST(FixedTime, TellsItsNameAndParameters) {
  EXPECT_EQ(FixedTime().name(), "fixed_time");
  EXPECT_EQ(FixedTime().parameters(), (SchemeParameters{{"period_ms", 1.0}}));
  EXPECT_EQ(FixedTime({.period = 100us}).parameters(), (SchemeParameters{{"period_ms", 0.1}}));
}

TEST(FixedTime, RefusesAPeriodThatIsNone) {
  const auto error = [](std::chrono::nanoseconds period) {
    return test::error_of([=] { FixedTime scheme({.period = period}); });
  };
  const std::string remedy = ": must be between 0.001 (1 us) and 1e9 ms";
  EXPECT_EQ(error(0ms), "period = 0 ms" + remedy);
  EXPECT_EQ(error(-1ms), "period = -1 ms" + remedy);
  EXPECT_EQ(error(2'000'000s), "period = 2000000000 ms" + remedy);
}

// ---- SingleEvent ----------------------------------------------------------------------------

TEST(SingleEvent, TakesOneAtOnce) {
  SingleEvent scheme;
  for (const std::size_t count : {1u, 2u, 1000u}) {
    const auto backlog = test::FakeBacklog::of(count);
    for (const bool due : {false, true}) {
      const Decision decision = scheme.decide(backlog.at(0, due));
      EXPECT_TRUE(decision.takes);
      EXPECT_EQ(decision.raw, 1u);
      EXPECT_EQ(decision.keep, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    }
  }
}

TEST(SingleEvent, TellsItsName) {
  EXPECT_EQ(SingleEvent().name(), "single_event");
  EXPECT_TRUE(SingleEvent().parameters().empty());
}

}  // namespace
}  // namespace asap::fixed_test
