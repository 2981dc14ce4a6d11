#include "core/atomics.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace asap::atomics_test {
namespace {

TEST(Relaxed, CountsLikeANumber) {
  Relaxed<std::uint64_t> count;
  EXPECT_EQ(count, 0u);
  ++count;
  count += 4;
  Relaxed<std::uint64_t> copy = count;
  copy = 7;
  EXPECT_EQ(count, 5u);
  EXPECT_EQ(copy.load(), 7u);
  count = copy;
  EXPECT_EQ(count, 7u);
}

TEST(Relaxed, IsReadByAnotherThreadWithoutARace) {
  constexpr std::uint64_t kEnd = 100'000;
  Relaxed<std::uint64_t> count;
  std::jthread writer([&] {
    for (std::uint64_t i = 0; i < kEnd; ++i) ++count;
  });
  for (std::uint64_t last = 0; last < kEnd;) {
    const std::uint64_t now = count;
    ASSERT_GE(now, last);
    last = now;
  }
}

}  // namespace
}  // namespace asap::atomics_test
