#include "core/made.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

namespace asap::made_test {
namespace {

template <class Exception>
std::string message_for(Exception exception) {
  return made<int>([&]() -> std::unique_ptr<int> { throw exception; }).message();
}

TEST(Made, IsWhatWasMade) {
  const Result<int> result = made<int>([] { return std::make_unique<int>(3); });
  ASSERT_TRUE(result);
  EXPECT_EQ(*result, 3);
}

TEST(Made, SaysWhatWasThrown) {
  EXPECT_EQ(message_for(std::invalid_argument("size = 0: must be at least 1")),
            "size = 0: must be at least 1");
  EXPECT_EQ(message_for(NoMemory("capacity = 9: choose less")), "capacity = 9: choose less");
  EXPECT_EQ(message_for(std::bad_alloc()), "no memory left");
  const std::string no_thread =
      message_for(std::system_error(std::make_error_code(std::errc::invalid_argument), "thread"));
  EXPECT_TRUE(no_thread.starts_with("thread: ")) << no_thread;
  EXPECT_EQ(message_for(5), "an exception that is no std::exception");
}

TEST(Made, ThrowsNothingItself) {
  static_assert(noexcept(made<int>([] { return std::make_unique<int>(3); })));
  EXPECT_EQ(message_of("of what was thrown"), "of what was thrown");
}

}  // namespace
}  // namespace asap::made_test
