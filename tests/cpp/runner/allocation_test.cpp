// A running pipeline allocates nothing, on neither side: push, filter, pack, deliver, feed back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>
#include <thread>
#include <utility>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "support/allocation_counter.hpp"
#include "support/streams.hpp"

namespace asap::allocation_test {
namespace {

using test::allocated_bytes;
using test::allocations;
using test::Events;

constexpr std::size_t kBatch = 1000;
constexpr std::chrono::minutes kBound{1};  // or a consumer that gets no turn delivers nothing

// How many events go through: a million, or 10^8 when the long tests are asked for.
std::uint64_t events_to_run() {
  const char* const asked = std::getenv("ASAP_LONG_TESTS");
  return asked != nullptr && std::string(asked) == "1" ? 100'000'000 : 1'000'000;
}

// Called by name: clang leaves out a `new` whose memory is not used.
TEST(LiveAllocations, AreCounted) {
  const std::uint64_t before = allocations();
  ::operator delete(::operator new(4));
  ::operator delete[](::operator new[](400));
  constexpr std::align_val_t kWide{64};
  ::operator delete(::operator new(6400, kWide), kWide);
  EXPECT_EQ(allocations(), before + 3);
}

// From the first push to stop(): what the thread that pushes has allocated.
std::uint64_t allocated_by_pushing(Pipeline& pipeline, std::uint64_t events) {
  Events batch = test::evenly_spaced(kBatch, 1);
  batch.front().x = 5000;  // one that is refused
  const std::uint64_t before = allocations();
  for (std::uint64_t pushed = 0; pushed < events; pushed += kBatch) {
    pipeline.push(batch);
    for (Event& event : batch) event.t += std::int64_t{kBatch};
    if (pushed % (100 * kBatch) == 0) pipeline.flush();
    if (pushed % (10 * kBatch) == 0) std::this_thread::yield();
  }
  pipeline.stop();
  return allocations() - before;
}

void allocates_nothing(Scheme& scheme, Execution execution) {
  Pipeline pipeline(scheme, {.latency = kBound,
                             .capacity = 100'000,
                             .validator = {.width = 4000, .height = 4000},
                             .execution = execution});
  std::uint64_t by_producer = 0;
  std::jthread producer([&] { by_producer = allocated_by_pushing(pipeline, events_to_run()); });
  std::uint64_t by_consumer = 0;
  std::uint64_t calls = 0;
  const Consumer work = [&](const Package&) { ++calls; };
  const std::uint64_t before = allocations();
  if (execution == Execution::whole) {
    Package package;
    while (pipeline.next(package, std::chrono::seconds(120)) == Pipeline::Next::package) {
      work(package);
    }
  } else {
    pipeline.run(work);
  }
  by_consumer = allocations() - before;
  producer.join();
  const Ledger ledger = pipeline.ledger();
  EXPECT_EQ(by_producer, 0u) << scheme.name();
  EXPECT_EQ(by_consumer, 0u) << scheme.name();
  EXPECT_GT(calls, 0u);
  EXPECT_EQ(ledger.received, events_to_run());
  EXPECT_EQ(ledger.rejected, events_to_run() / kBatch);
  EXPECT_GT(ledger.delivered, ledger.received / 100) << scheme.name();
}

TEST(LiveAllocations, NoneByALookIntoTheSameStats) {
  const Pipeline pipeline({.capacity = 1000}, [](EventSpan) {});
  PipelineStats stats{};
  const std::uint64_t before = allocations();
  for (int look = 0; look < 10; ++look) pipeline.stats(stats);
  EXPECT_EQ(allocations(), before);
  EXPECT_EQ(stats.run, 1u);
}

TEST(LiveAllocations, None) {
  for (const Execution execution : {Execution::whole, Execution::anytime}) {
    Deadline deadline({.latency = kBound});
    allocates_nothing(deadline, execution);
    Asap2020 asap2020({.rate_bound = 1e6, .first_size = 100});
    allocates_nothing(asap2020, execution);
    FixedSize fixed_size({.size = 777});
    allocates_nothing(fixed_size, execution);
    Greedy greedy;
    allocates_nothing(greedy, execution);
  }
}

// ---- what a pipeline takes ------------------------------------------------------------------

TEST(PipelineMemory, IsWhatIsCounted) {
  const FrontFilter all = [](EventSpan events, std::span<Event> passed) {
    std::ranges::copy(events, passed.begin());
    return events.size();
  };
  for (const std::size_t capacity : {1UL, 1000UL, 16'384UL, 65'536UL, 1'000'000UL}) {
    const RunConfig configs[] = {
        {.capacity = capacity, .log_rows = 0},
        {.capacity = capacity, .prefault = true},
        {.capacity = capacity, .front_filter = all, .log_rows = 7, .max_copied = 5000}};
    for (const RunConfig& config : configs) {
      Consumer nothing = [](EventSpan) {};
      RunConfig given = config;
      const std::size_t before = allocated_bytes();
      const Pipeline pipeline(std::move(given), std::move(nothing));
      EXPECT_EQ(allocated_bytes() - before, memory_bytes(config)) << capacity;
    }
  }
}

// The figures of notebooks/board.md.
TEST(PipelineMemory, FitsASmallBoard) {
  const PipelineMemory memory = Pipeline::memory({.capacity = 65'536, .log_rows = 0});
  EXPECT_LE(memory.total(), 2'600'000u);
  EXPECT_LE(memory.log + memory.rest, 256'000u);
  const RunConfig small{.capacity = 16'384, .log_rows = 0, .max_copied = 4096};
  EXPECT_LE(memory_bytes(small), 600'000u);
}

}  // namespace
}  // namespace asap::allocation_test
