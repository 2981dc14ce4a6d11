#include "synthetic/time_sorted_block.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace asap::time_sorted_block_test {
namespace {

std::vector<Event> closed(TimeSortedBlock& block) {
  const EventSpan events = block.close();
  return {events.begin(), events.end()};
}

TEST(TimeSortedBlock, SortsByTimeAndKeepsTheOrderOfEqualTimes) {
  TimeSortedBlock block{10, 10, 4};
  block.open(1000, 20);
  block.add(1, 2, true, 19);
  block.add(3, 4, false, 0);
  block.add(5, 6, true, 7);
  block.add(7, 8, false, 7);
  EXPECT_EQ(
      closed(block),
      (std::vector<Event>{{3, 4, 0, 1000}, {5, 6, 1, 1007}, {7, 8, 0, 1007}, {1, 2, 1, 1019}}));
}

TEST(TimeSortedBlock, DoesNotSeeWhatLiesOutsideTheSensor) {
  TimeSortedBlock block{10, 8, 8};
  block.open(0, 1);
  block.add(-1, 0, true, 0);
  block.add(0, -1, true, 0);
  block.add(10, 0, true, 0);
  block.add(0, 8, true, 0);
  block.add(9, 7, true, 0);
  EXPECT_EQ(closed(block), (std::vector<Event>{{9, 7, 1, 0}}));
}

TEST(TimeSortedBlock, StartsEmptyAtEveryStep) {
  TimeSortedBlock block{10, 10, 2};
  block.open(0, TimeSortedBlock::kMaxStep_us);
  block.add(1, 1, true, TimeSortedBlock::kMaxStep_us - 1);
  EXPECT_EQ(block.close().size(), 1U);
  block.open(-500, 3);
  EXPECT_TRUE(block.close().empty());
  block.open(-500, 3);
  block.add(2, 2, false, 2);
  EXPECT_EQ(closed(block), (std::vector<Event>{{2, 2, 0, -498}}));
}

}  // namespace
}  // namespace asap::time_sorted_block_test
