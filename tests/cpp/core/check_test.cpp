#include "core/check.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <new>
#include <string>

#include "support/errors.hpp"

namespace asap::check_test {
namespace {

// ---- require --------------------------------------------------------------------------------

using test::error_of;

TEST(Require, PassesWhatIsRight) { EXPECT_NO_THROW(require(true, "size", 1, "be good")); }

TEST(Require, NamesFieldValueAndRemedy) {
  EXPECT_EQ(error_of([] { require(false, "size", 0, "must be at least 1 event"); }),
            "size = 0: must be at least 1 event");
}

TEST(Require, WritesNumbersInFull) {
  const auto text = [](auto value) {
    const std::string error = error_of([value] { require(false, "f", value, "r"); });
    return error.substr(4, error.size() - 7);
  };
  EXPECT_EQ(text(-1.1), "-1.1");
  EXPECT_EQ(text(0.1), "0.1");
  EXPECT_EQ(text(1e300), "1e+300");
  EXPECT_EQ(text(1234567.25), "1234567.25");
  EXPECT_EQ(text(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(text(-std::numeric_limits<double>::infinity()), "-inf");
  EXPECT_EQ(text(std::numeric_limits<std::uint64_t>::max()), "18446744073709551615");
  EXPECT_EQ(text(std::numeric_limits<std::int64_t>::min()), "-9223372036854775808");
}

// ---- allocate -------------------------------------------------------------------------------

TEST(Allocate, GivesMemoryThatCanBeUsed) {
  const auto memory = detail::allocate<int>(1000, "capacity", 1000);
  memory[0] = 1;
  memory[999] = 2;
  EXPECT_EQ(memory[0] + memory[999], 3);
}

// A size that no allocator is asked for, so that sanitizers agree.
TEST(Allocate, NamesFieldValueAndRemedyOfWhatCannotBeHad) {
  try {
    detail::allocate<double>(std::numeric_limits<std::size_t>::max(), "capacity", 7);
    FAIL();
  } catch (const std::bad_alloc& error) {
    const NoMemory copy = dynamic_cast<const NoMemory&>(error);
    EXPECT_EQ(std::string(copy.what()),
              "capacity = 7: needs 1.37e+11 GiB of memory, which cannot be had; choose less");
  }
}

}  // namespace
}  // namespace asap::check_test
