#include "runner/stall_watch.hpp"

#include <gtest/gtest.h>

namespace asap::stall_watch_test {
namespace {

constexpr std::int64_t kBound = 1000;

TEST(StallWatch, AwakeForLongIsStalledUntilItLooksUp) {
  StallWatch watch;
  watch.looks_up(10'000, kBound);
  watch.works();
  EXPECT_FALSE(watch.stalled(14'000, kBound));
  EXPECT_TRUE(watch.stalled(14'001, kBound));
  watch.looks_up(20'000, kBound);
  EXPECT_FALSE(watch.stalled(20'000, kBound));
}

TEST(StallWatch, SleepIsNoStall) {
  StallWatch watch;
  watch.looks_up(0, kBound);
  watch.sleeps();
  EXPECT_FALSE(watch.stalled(1'000'000'000, kBound));
  watch.looks_up(1'000'000'000, kBound);
  EXPECT_FALSE(watch.stalled(1'000'004'000, kBound));
  EXPECT_TRUE(watch.stalled(1'000'004'001, kBound));
}

TEST(StallWatch, AConsumerThatNeverCameIsStalled) {
  StallWatch watch;
  watch.begins(500);
  EXPECT_FALSE(watch.stalled(4500, kBound));
  EXPECT_TRUE(watch.stalled(4501, kBound));
}

TEST(StallWatch, LearnsThatPackagesTakeLong) {
  StallWatch watch;
  std::int64_t now = 0;
  for (int package = 0; package < 100; ++package) {
    watch.looks_up(now, kBound);
    watch.works();
    now += 3 * kBound;
  }
  watch.looks_up(now, kBound);
  EXPECT_FALSE(watch.stalled(now + 11 * kBound, kBound));
  EXPECT_TRUE(watch.stalled(now + 12 * kBound + 1, kBound));
}

TEST(StallWatch, AStallIsNotWhatIsExpectedNext) {
  StallWatch watch;
  watch.looks_up(0, kBound);
  watch.works();
  watch.looks_up(1000 * kBound, kBound);
  watch.works();
  EXPECT_TRUE(watch.stalled(1005 * kBound, kBound));
}

TEST(StallWatch, SleepIsNoProcessingTime) {
  StallWatch watch;
  std::int64_t now = 0;
  for (int nap = 0; nap < 100; ++nap) {
    watch.looks_up(now, kBound);
    watch.sleeps();
    now += 100 * kBound;
  }
  watch.looks_up(now, kBound);
  EXPECT_TRUE(watch.stalled(now + 4 * kBound + 1, kBound));
}

}  // namespace
}  // namespace asap::stall_watch_test
