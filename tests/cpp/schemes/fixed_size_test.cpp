#include "asap/schemes/fixed_size.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::fixed_size_test {
namespace {

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

}  // namespace
}  // namespace asap::fixed_size_test
