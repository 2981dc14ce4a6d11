#include "packager/kept_times.hpp"

#include <gtest/gtest.h>

namespace asap::kept_times_test {
namespace {

TEST(KeptTimes, LeavesOutWhatKeptNothing) {
  KeptTimes times(4);
  times.note(0, 100);
  times.note(3, 200);
  times.note(3, 300);
  times.note(8, 400);
  ASSERT_EQ(times.runs().size(), 2u);
  EXPECT_EQ(times.runs()[0].end, 3u);
  EXPECT_EQ(times.runs()[0].time_ns, 200);
  EXPECT_EQ(times.runs()[1].end, 8u);
  EXPECT_EQ(times.runs()[1].time_ns, 400);
  times.clear();
  EXPECT_TRUE(times.runs().empty());
}

}  // namespace
}  // namespace asap::kept_times_test
