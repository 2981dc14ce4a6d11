#include "asap/telemetry/ledger.hpp"

#include <gtest/gtest.h>

namespace asap::ledger_test {
namespace {

TEST(Ledger, IsBalancedWhenEveryEventIsSomewhere) {
  EXPECT_TRUE(Ledger{}.balanced());
  const Ledger ledger{.received = 1111111,
                      .rejected = 1,
                      .filtered = 10,
                      .discarded = 100,
                      .stale = 1000,
                      .overflow = 10000,
                      .delivered = 100000,
                      .pending = 1000000};
  EXPECT_TRUE(ledger.balanced());
}

TEST(Ledger, IsNotBalancedWhenOneCounterIsOffByOne) {
  const auto off_by_one = [](std::uint64_t Ledger::* counter) {
    Ledger ledger;
    ++(ledger.*counter);
    return !ledger.balanced();
  };
  EXPECT_TRUE(off_by_one(&Ledger::received));
  EXPECT_TRUE(off_by_one(&Ledger::rejected));
  EXPECT_TRUE(off_by_one(&Ledger::filtered));
  EXPECT_TRUE(off_by_one(&Ledger::discarded));
  EXPECT_TRUE(off_by_one(&Ledger::stale));
  EXPECT_TRUE(off_by_one(&Ledger::overflow));
  EXPECT_TRUE(off_by_one(&Ledger::delivered));
  EXPECT_TRUE(off_by_one(&Ledger::pending));
}

TEST(Ledger, ADifferenceBalances) {
  const Ledger earlier{.received = 100, .rejected = 1, .delivered = 9, .pending = 90};
  const Ledger later{.received = 150, .rejected = 3, .stale = 5, .delivered = 130, .pending = 12};
  ASSERT_TRUE(earlier.balanced() && later.balanced());
  const Ledger since = later - earlier;
  EXPECT_EQ(since,
            (Ledger{.received = 140, .rejected = 2, .stale = 5, .delivered = 121, .pending = 12}));
  EXPECT_TRUE(since.balanced());
}

}  // namespace
}  // namespace asap::ledger_test
