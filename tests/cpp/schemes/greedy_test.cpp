#include "asap/schemes/greedy.hpp"

#include <gtest/gtest.h>

#include "support/fake_backlog.hpp"

namespace asap {
namespace {

TEST(Greedy, TakesAllThatWaitsAtOnce) {
  Greedy scheme;
  for (const std::size_t count : {1u, 2u, 1000u}) {
    const auto backlog = test::FakeBacklog::of(count);
    for (const bool due : {false, true}) {
      const Decision decision = scheme.decide(backlog.at(0, due));
      EXPECT_TRUE(decision.takes);
      EXPECT_EQ(decision.raw, count);
      EXPECT_EQ(decision.keep, 1.0);
      EXPECT_EQ(decision.stale, 0u);
    }
  }
}

TEST(Greedy, TellsItsName) {
  EXPECT_EQ(Greedy().name(), "greedy");
  EXPECT_TRUE(Greedy().parameters().empty());
}

}  // namespace
}  // namespace asap
