#include "runner/read_ahead.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "core/random.hpp"
#include "support/streams.hpp"

namespace asap::read_ahead_test {
namespace {

using test::evenly_spaced;
using test::Events;
using namespace std::chrono_literals;

TEST(ReadAhead, HandsOnEveryEventInOrder) {
  const Events events = evenly_spaced(3 * ReadAhead::kBlocks * ReadAhead::kBlockEvents / 2, 1);
  ReadAhead source;
  std::thread reader([&] {
    const CounterRandom random(1);
    for (std::size_t at = 0; at < events.size();) {
      const std::size_t largest = random(at) % 8 == 0 ? 4 * ReadAhead::kBlockEvents : 5000;
      const std::size_t size = std::min(random(~at) % largest, events.size() - at);
      EXPECT_TRUE(source.feed(EventSpan(events).subspan(at, size)));
      at += size;
    }
    source.finish();
  });
  std::size_t at = 0;
  for (EventSpan chunk = source.next(); !chunk.empty(); chunk = source.next()) {
    std::this_thread::yield();  // the chunk must stay as it is meanwhile
    ASSERT_TRUE(
        std::equal(chunk.begin(), chunk.end(), events.begin() + static_cast<std::ptrdiff_t>(at)));
    at += chunk.size();
  }
  reader.join();
  EXPECT_EQ(at, events.size());
  EXPECT_TRUE(source.next().empty());
}

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

TEST(ReadAhead, CancelLetsAReaderGoThatWaits) {
  ReadAhead source;
  std::thread canceller([&] {
    std::this_thread::sleep_for(5ms);
    source.cancel();
  });
  const Events events = evenly_spaced((ReadAhead::kBlocks + 1) * ReadAhead::kBlockEvents, 1);
  EXPECT_FALSE(source.feed(events));
  canceller.join();
  EXPECT_FALSE(source.feed(events));
  EXPECT_TRUE(source.next().empty());
}

}  // namespace
}  // namespace asap::read_ahead_test
