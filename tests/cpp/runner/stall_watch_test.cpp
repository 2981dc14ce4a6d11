#include "runner/stall_watch.hpp"

#include <gtest/gtest.h>

namespace asap::stall_watch_test {
namespace {

constexpr std::int64_t kBound = 1000;

TEST(StallWatch, SleepIsNoStall) {
  StallWatch watch;
  watch.on_wake(0, kBound);
  watch.on_sleep();
  EXPECT_FALSE(watch.stalled(1'000'000'000, kBound));
  watch.on_wake(1'000'000'000, kBound);
  EXPECT_FALSE(watch.stalled(1'000'004'000, kBound));
  EXPECT_TRUE(watch.stalled(1'000'004'001, kBound));
}

TEST(StallWatch, LearnsThatPackagesTakeLong) {
  StallWatch watch;
  std::int64_t now = 0;
  for (int package = 0; package < 100; ++package) {
    watch.on_wake(now, kBound);
    watch.on_work();
    now += 3 * kBound;
  }
  watch.on_wake(now, kBound);
  EXPECT_FALSE(watch.stalled(now + 11 * kBound, kBound));
  EXPECT_TRUE(watch.stalled(now + 12 * kBound + 1, kBound));
}

TEST(StallWatch, AStallIsNotWhatIsExpectedNext) {
  StallWatch watch;
  watch.on_wake(0, kBound);
  watch.on_work();
  watch.on_wake(1000 * kBound, kBound);
  watch.on_work();
  EXPECT_TRUE(watch.stalled(1005 * kBound, kBound));
}

}  // namespace
}  // namespace asap::stall_watch_test
