#include "core/bit_log.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "asap/core/random.hpp"
#include "support/allocation_counter.hpp"

namespace asap::bit_log_test {
namespace {

std::vector<bool> bits_of(const BitLog& log) {
  std::vector<bool> bits;
  for (std::size_t i = 0; i < log.size(); ++i) bits.push_back(log[i]);
  return bits;
}

TEST(BitLog, HoldsWhatWasAppendedInOrder) {
  BitLog log;
  log.append(true);
  log.append(false);
  log.append(3, true);
  log.append(0, true);
  EXPECT_EQ(bits_of(log), (std::vector<bool>{true, false, true, true, true}));
}

TEST(BitLog, AgreesWithOneBitAtATimeForAnyRuns) {
  const CounterRandom random(1);
  BitLog log;
  std::vector<bool> expected;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const std::size_t count = random(2 * i) % 200;
    const bool bit = random(2 * i + 1) % 2 == 0;
    log.append(count, bit);
    expected.insert(expected.end(), count, bit);
  }
  EXPECT_EQ(bits_of(log), expected);
}

TEST(BitLog, DoesNotAllocateWhereRoomWasMade) {
  BitLog log;
  log.append(37, true);
  log.make_room(1000);
  const std::size_t before = test::allocations();
  log.append(900, false);
  for (int i = 0; i < 100; ++i) log.append(true);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace asap::bit_log_test
