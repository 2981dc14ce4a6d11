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

}  // namespace
}  // namespace asap::ledger_test
