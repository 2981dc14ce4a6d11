#include "runner/read_ahead.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "support/streams.hpp"

namespace asap::read_ahead_test {
namespace {

using test::evenly_spaced;
using test::Events;
using namespace std::chrono_literals;

TEST(ReadAhead, AChunkStaysValidUntilTheCallAfter) {
  const Events events = evenly_spaced(ReadAhead::kBlockEvents, 1);
  ReadAhead source;
  for (std::size_t i = 0; i < ReadAhead::kBlocks; ++i) ASSERT_TRUE(source.feed(events));
  const EventSpan first = source.next();
  const Events other(ReadAhead::kBlockEvents, Event{9, 9, 1, 9});
  std::atomic<bool> fed{false};
  std::thread reader([&] {
    source.feed(other);
    fed = true;
  });
  std::this_thread::sleep_for(20ms);
  EXPECT_FALSE(fed) << "the reader waits while all blocks are full";
  EXPECT_TRUE(std::equal(first.begin(), first.end(), events.begin()));
  source.next();  // gives the first block back
  reader.join();
  EXPECT_TRUE(fed);
}

}  // namespace
}  // namespace asap::read_ahead_test
