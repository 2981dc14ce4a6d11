#include "asap/filter/front_filter.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "support/streams.hpp"

namespace asap::front_filter_test {
namespace {

struct OnlyOn {
  std::size_t process(EventSpan events, Event* out) noexcept {
    std::size_t passed = 0;
    for (const Event& event : events) {
      out[passed] = event;
      passed += event.p == 1 ? 1U : 0U;
    }
    return passed;
  }
};

TEST(FrontFilter, IsMadeOfAFiltersProcess) {
  OnlyOn filter;
  const FrontFilter before = [&](EventSpan events, Event* out) {
    return filter.process(events, out);
  };
  const test::Events events = test::evenly_spaced(5, 1);
  std::vector<Event> out(events.size());
  ASSERT_EQ(before(events, out.data()), 2u);
  EXPECT_EQ(test::numbers_of(EventSpan(out).first(2)), (std::vector<std::uint64_t>{1, 3}));
  EXPECT_FALSE(FrontFilter{}) << "none";
}

}  // namespace
}  // namespace asap::front_filter_test
