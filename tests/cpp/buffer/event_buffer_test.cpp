#include "buffer/event_buffer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <limits>
#include <vector>

#include "core/random.hpp"
#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap::event_buffer_test {
namespace {

using test::error_of;
using test::evenly_spaced;
using test::Events;
using test::number_of;
using test::numbered;
using test::numbers_of;

using Numbers = std::vector<std::uint64_t>;

// Goes back to the first slot whenever a push finds it empty.
using RestlessBuffer = BasicEventBuffer<StdAtomics, 1>;

constexpr std::uint64_t kNearTheEnd = std::numeric_limits<std::uint64_t>::max() - 5;

Numbers waiting_in(EventBuffer& buffer) {
  const EventPieces pieces = buffer.peek();
  Numbers numbers = numbers_of(pieces.first);
  for (const Event& event : pieces.second) numbers.push_back(number_of(event));
  return numbers;
}

// The capacities where masks and wraps go wrong.
class EventBufferOfSize : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(, EventBufferOfSize,
                         testing::Values(1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 1023, 1024, 1025));

// The same calls on the ring and on a plain queue; everything that can be seen must agree.
template <class Buffer>
void compare_with_a_queue(std::size_t capacity, std::uint64_t first_index, std::uint64_t count) {
  Buffer buffer(capacity, first_index);
  std::deque<Event> queue;
  const CounterRandom random(capacity);
  std::uint64_t overflow = 0;
  std::uint64_t number = 0;
  std::vector<Event> batch;
  for (std::uint64_t round = 0; number < count; ++round) {
    batch.clear();
    const std::uint64_t pushed = random(2 * round) % (2 * capacity + 1);
    for (std::uint64_t i = 0; i < pushed; ++i) {
      batch.push_back(numbered(number, static_cast<std::int64_t>(number)));
      ++number;
    }
    const std::size_t fits = std::min<std::size_t>(pushed, capacity - queue.size());
    queue.insert(queue.end(), batch.begin(), batch.begin() + static_cast<std::ptrdiff_t>(fits));
    overflow += pushed - fits;
    ASSERT_EQ(buffer.push(batch), fits);
    ASSERT_EQ(buffer.overflow(), overflow);
    ASSERT_EQ(buffer.size(), queue.size());

    const std::size_t limit = random(2 * round + 1) % (capacity + 2);
    const EventPieces pieces = buffer.peek(limit);
    ASSERT_EQ(pieces.size(), std::min(limit, queue.size()));
    ASSERT_TRUE(std::equal(pieces.first.begin(), pieces.first.end(), queue.begin()));
    ASSERT_TRUE(std::equal(pieces.second.begin(), pieces.second.end(),
                           queue.begin() + static_cast<std::ptrdiff_t>(pieces.first.size())));
    for (std::size_t i = 0; i < pieces.size(); i += 1 + pieces.size() / 4) {
      ASSERT_EQ(pieces[i], queue[i]);
    }
    const std::size_t consumed = pieces.size() - pieces.size() / 3;
    buffer.consume(consumed);
    queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(consumed));
    ASSERT_EQ(buffer.size(), queue.size());
    ASSERT_EQ(buffer.tail() - buffer.head(), queue.size());
  }
}

TEST_P(EventBufferOfSize, AgreesWithAQueue) {
  compare_with_a_queue<EventBuffer>(GetParam(), 0, 100'000);
}

TEST_P(EventBufferOfSize, AgreesWithAQueueWhereTheIndicesWrap) {
  compare_with_a_queue<EventBuffer>(GetParam(), kNearTheEnd, 100'000);
}

TEST_P(EventBufferOfSize, AgreesWithAQueueWhereItGoesBackToTheFirstSlot) {
  compare_with_a_queue<RestlessBuffer>(GetParam(), kNearTheEnd, 100'000);
}

// A consumer that keeps up works in the same few pages for ever; a backlog gets all there are.
TEST(EventBuffer, StaysNearTheFirstSlotWhereTheConsumerKeepsUp) {
  EventBuffer buffer(std::size_t{1} << 17);
  const Events events = evenly_spaced(std::size_t{1} << 17, 1);
  const EventSpan block = EventSpan(events).first(1000);
  buffer.push(block);
  const Event* const first = buffer.peek().first.data();
  buffer.consume(1000);
  for (int i = 0; i < 1000; ++i) {
    buffer.push(block);
    const EventPieces pieces = buffer.peek();
    ASSERT_EQ(pieces.first.size(), 1000u);
    ASSERT_LT(pieces.first.data() - first, 20'000);
    buffer.consume(1000);
  }
  EXPECT_EQ(buffer.push(events), events.size());
  EXPECT_EQ(waiting_in(buffer), numbers_of(events));
}

TEST(EventBuffer, RefusesACapacityThatCannotBe) {
  const auto error = [](std::size_t capacity) {
    return error_of([capacity] { EventBuffer buffer(capacity); });
  };
  EXPECT_EQ(error(0), "capacity = 0: must be between 1 and 2^40 events");
  EXPECT_EQ(error(std::numeric_limits<std::size_t>::max() - 1),
            "capacity = 18446744073709551614: must be between 1 and 2^40 events");
  EXPECT_EQ(error(EventBuffer::kMaxCapacity + 1),
            "capacity = 1099511627777: must be between 1 and 2^40 events");
}

}  // namespace
}  // namespace asap::event_buffer_test
