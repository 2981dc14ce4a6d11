#include "asap/schemes/single_event.hpp"

#include <gtest/gtest.h>

#include "support/fake_backlog.hpp"

namespace asap::single_event_test {
namespace {

TEST(SingleEvent, TakesOneAtOnce) {
  SingleEvent scheme;
  for (const std::size_t count : {1u, 2u, 1000u}) {
    const auto backlog = test::FakeBacklog::of(count);
    for (const bool due : {false, true}) {
      const Decision decision = scheme.decide(backlog.at(0, due));
      EXPECT_TRUE(decision.takes);
      EXPECT_EQ(decision.raw, 1u);
      EXPECT_EQ(decision.keep, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    }
  }
}

TEST(SingleEvent, TellsItsName) {
  EXPECT_EQ(SingleEvent().name(), "single_event");
  EXPECT_TRUE(SingleEvent().parameters().empty());
}

}  // namespace
}  // namespace asap::single_event_test
