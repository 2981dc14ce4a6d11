#include "asap/core/nonblocking.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <type_traits>

namespace asap::nonblocking_test {
namespace {

int marked(int number) noexcept ASAP_NONBLOCKING { return number + 1; }

// That the mark is checked, tests/realtime/run shows.
TEST(Nonblocking, TheMarkChangesNothingAtRunTime) { EXPECT_EQ(marked(1), 2); }

TEST(Nonblocking, ExemptReturnsWhatTheCallReturns) {
  int number = 3;
  int& same = exempt([&]() -> int& { return number; });
  EXPECT_EQ(&same, &number);
  EXPECT_EQ(exempt([] { return 4; }), 4);
}

TEST(Nonblocking, ExemptThrowsWhatTheCallThrows) {
  const auto throws = [] { throw std::runtime_error("full"); };
  const auto returns = []() noexcept {};
  EXPECT_THROW(exempt(throws), std::runtime_error);
  static_assert(noexcept(exempt(returns)) && !noexcept(exempt(throws)));
}

}  // namespace
}  // namespace asap::nonblocking_test
