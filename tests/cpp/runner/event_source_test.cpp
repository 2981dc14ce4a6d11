#include "asap/runner/event_source.hpp"

#include <gtest/gtest.h>

#include "support/streams.hpp"

namespace asap::event_source_test {
namespace {

TEST(SpanSource, GivesAllAtOnceAndThenTheEnd) {
  const test::Events events = test::evenly_spaced(5, 1);
  SpanSource source(events);
  const EventSpan chunk = source.next();
  EXPECT_EQ(chunk.data(), events.data());
  EXPECT_EQ(chunk.size(), 5u);
  EXPECT_TRUE(source.next().empty());
  EXPECT_TRUE(source.next().empty());
}

}  // namespace
}  // namespace asap::event_source_test
