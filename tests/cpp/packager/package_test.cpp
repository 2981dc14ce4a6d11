#include "asap/packager/package.hpp"

#include <gtest/gtest.h>

#include "support/streams.hpp"

namespace asap::package_test {
namespace {

TEST(Package, KnowsItsTimesAndLosses) {
  const test::Events events = test::at_times({3, 5, 9});
  const Package package{.events = events, .stale_before = 4, .overflow_before = 5};
  EXPECT_EQ(package.t_first(), 3);
  EXPECT_EQ(package.t_last(), 9);
  EXPECT_EQ(package.lost_before(), 9u);
}

TEST(Package, GoesWhereEventsAreWanted) {
  const test::Events events = test::at_times({3, 5});
  const auto count = [](EventSpan span) { return span.size(); };
  EXPECT_EQ(count(Package{.events = events}), 2u);
}

}  // namespace
}  // namespace asap::package_test
