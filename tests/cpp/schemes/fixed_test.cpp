#include "asap/schemes/fixed.hpp"

#include <gtest/gtest.h>

#include <cstdint>

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
      EXPECT_EQ(decision.gamma, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    } else {
      EXPECT_EQ(decision.until_count, 3u);
      EXPECT_EQ(decision.until_ns, kNever);
    }
  }
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
  EXPECT_EQ(decision.gamma, 1.0);
}

TEST(FixedTime, WhenDueTakesThePartOfThePeriodThatIsThere) {
  FixedTime scheme({.period = 20ms});
  const FakeBacklog backlog({100, 200, 300});
  EXPECT_FALSE(scheme.decide(backlog.at(1000)).takes);
  const Decision decision = scheme.decide(backlog.at(1000, true));
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.raw, 3u);
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
      EXPECT_EQ(decision.gamma, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    }
  }
}

}  // namespace
}  // namespace asap::fixed_test
