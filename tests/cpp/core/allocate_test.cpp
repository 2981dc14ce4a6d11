#include "asap/core/allocate.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <new>
#include <string>

namespace asap::allocate_test {
namespace {

TEST(Allocate, GivesMemoryThatCanBeUsed) {
  const auto memory = allocate<int>(1000, "capacity", 1000);
  memory[0] = 1;
  memory[999] = 2;
  EXPECT_EQ(memory[0] + memory[999], 3);
}

// A size that no allocator is asked for, so that sanitizers agree.
TEST(Allocate, NamesFieldValueAndRemedyOfWhatCannotBeHad) {
  try {
    allocate<double>(std::numeric_limits<std::size_t>::max(), "capacity", 7);
    FAIL();
  } catch (const std::bad_alloc& error) {
    const NoMemory copy = dynamic_cast<const NoMemory&>(error);
    EXPECT_EQ(std::string(copy.what()),
              "capacity = 7: needs 1.37e+11 GiB of memory, which cannot be had; choose less");
  }
}

}  // namespace
}  // namespace asap::allocate_test
