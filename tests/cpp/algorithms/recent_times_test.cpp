#include "algorithms/recent_times.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <vector>

#include "asap/core/random.hpp"
#include "support/allocation_counter.hpp"

namespace recent_times_test {
namespace {

using asap::RecentTimes;
constexpr std::int64_t kLow = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kHigh = std::numeric_limits<std::int64_t>::max();

TEST(RecentTimes, CountsFromZeroOrFromBeforeTheFirstStamp) {
  RecentTimes times(1, 0);
  EXPECT_EQ(times.time_of(10), 10);
  times.clear();
  EXPECT_EQ(times.time_of(-1000), 1);
  EXPECT_EQ(times.time_of(-400), 601);
}

TEST(RecentTimes, AStampThatGoesBackCountsAsTheLatest) {
  RecentTimes times(1, 0);
  EXPECT_EQ(times.time_of(100), 100);
  EXPECT_EQ(times.time_of(40), 100);
  EXPECT_EQ(times.time_of(101), 101);
  times.clear();
  EXPECT_EQ(times.time_of(40), 40);
}

// Ages by 128-bit arithmetic beside ages by the map, for every window up to the largest.
void expect_ages(std::int64_t start_us, std::int64_t largest_step_us, RecentTimes::Time never) {
  constexpr std::size_t kCells = 4;
  const asap::CounterRandom random(3);
  RecentTimes times(kCells, never);
  std::vector<bool> fired(kCells);
  std::vector<std::uint64_t> stamps(kCells);
  std::int64_t stamp = start_us;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const RecentTimes::Time now = times.time_of(stamp);
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      const std::int64_t age = std::int64_t{now} - times.data()[cell];
      const std::uint64_t truth = static_cast<std::uint64_t>(stamp) - stamps[cell];
      constexpr auto kLongest = static_cast<std::uint64_t>(RecentTimes::kMaxWindow_us);
      if (fired[cell] && truth <= kLongest) {
        ASSERT_EQ(age, static_cast<std::int64_t>(truth));
      } else if (fired[cell] || never == RecentTimes::kLongAgo) {
        ASSERT_GT(age, RecentTimes::kMaxWindow_us);
      }
    }
    const std::size_t own = random(2 * i) % kCells;
    times.data()[own] = now;
    stamps[own] = static_cast<std::uint64_t>(stamp);
    fired[own] = true;
    const auto step = static_cast<std::int64_t>(random(2 * i + 1) %
                                                (static_cast<std::uint64_t>(largest_step_us) + 1));
    if (stamp > kHigh - step) break;
    stamp += step;
  }
}

TEST(RecentTimes, AgesAreExactUpToTheLargestWindow) {
  for (const RecentTimes::Time never : {RecentTimes::Time{0}, RecentTimes::kLongAgo}) {
    for (const std::int64_t start :
         {kLow, std::int64_t{-50}, std::int64_t{0}, std::int64_t{1} << 52}) {
      for (const std::int64_t step :
           {std::int64_t{1'000}, RecentTimes::kMaxWindow_us, std::int64_t{1} << 32, kHigh / 50}) {
        expect_ages(start, step, never);
      }
    }
  }
}

TEST(RecentTimes, TheOriginMovesWithoutAllocation) {
  RecentTimes times(1000, 0);
  times.time_of(0);
  const std::size_t before = asap::test::allocations();
  EXPECT_GT(times.time_of(kHigh), 0);
  times.clear();
  EXPECT_EQ(asap::test::allocations(), before);
}

TEST(RecentTimes, ClearForgetsTheCells) {
  RecentTimes times(2, RecentTimes::kLongAgo);
  times.data()[1] = times.time_of(5);
  times.clear();
  EXPECT_EQ(times.data()[1], RecentTimes::kLongAgo);
}

}  // namespace
}  // namespace recent_times_test
