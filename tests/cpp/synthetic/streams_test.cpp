#include "asap/synthetic/streams.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "support/allocation_counter.hpp"
#include "synthetic/scene_checks.hpp"

namespace asap::streams_test {
namespace {

using std::chrono::microseconds;

// Blocks of 3, 1 and 2 events.
class ThreeBlocks final : public EventStream {
 public:
  EventSpan next() noexcept override {
    constexpr std::array<std::size_t, 5> kEnds{3, 4, 6, 6, 6};
    const std::size_t begin = end_;
    end_ = kEnds.at(block_++);
    return EventSpan(events_).subspan(begin, end_ - begin);
  }

 private:
  std::array<Event, 6> events_{
      {{0, 0, 0, 0}, {0, 0, 0, 1}, {0, 0, 0, 2}, {0, 0, 0, 3}, {0, 0, 0, 4}, {0, 0, 0, 5}}};
  std::size_t block_ = 0;
  std::size_t end_ = 0;
};

TEST(EventStream, IsReadInWholeBlocksUntilThereIsEnough) {
  ThreeBlocks stream;
  EXPECT_EQ(read_events(stream, 1).size(), 3U);
  EXPECT_EQ(read_events(stream, 1).size(), 1U);
  const auto rest = read_events(stream, 3);
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_EQ(rest.front().t, 4);
  EXPECT_TRUE(read_events(stream, 1).empty());

  ThreeBlocks exact;
  EXPECT_EQ(read_events(exact, 3).size(), 3U);
  EXPECT_EQ(read_events(exact, 2).size(), 3U);
}

TEST(EventStream, AllocatesNothingAfterConstruction) {
  ShakenPattern shaken{{.duration = microseconds(300'000)}};
  FlightOverChairs flight{{.width = 120,
                           .height = 100,
                           .duration = microseconds(8'000'000),
                           .last_rate_hz = 0.3e6,
                           .chair_px = 20}};
  for (EventStream* stream :
       {static_cast<EventStream*>(&shaken), static_cast<EventStream*>(&flight)}) {
    const std::size_t before = test::allocations();
    std::size_t events = 0;
    for (EventSpan block = stream->next(); !block.empty(); block = stream->next()) {
      events += block.size();
    }
    EXPECT_EQ(test::allocations(), before);
    EXPECT_GT(events, 100'000U);
  }
}

template <class Stream, class Config>
void expect_a_function_of_seed_and_start(const Config& config) {
  const auto events = test::all_events<Stream>(config);
  test::expect_well_formed(events, config);
  Stream stream{config};
  std::vector<Event> joined;
  for (auto part = read_events(stream, 1000); !part.empty(); part = read_events(stream, 1000)) {
    joined.insert(joined.end(), part.begin(), part.end());
  }
  EXPECT_EQ(joined, events);
  Config other = config;
  other.start += microseconds(1'000'000'007);
  auto later = test::all_events<Stream>(other);
  for (Event& event : later) event.t -= 1'000'000'007;
  EXPECT_EQ(later, events);
  other.seed += 1;
  EXPECT_NE(test::all_events<Stream>(other).size(), events.size());
}

TEST(EventStream, FollowsFromSeedAndStart) {
  expect_a_function_of_seed_and_start<ShakenPattern>(
      ShakenPatternConfig{.duration = microseconds(200'000)});
  expect_a_function_of_seed_and_start<ShakenPattern>(
      ShakenPatternConfig{.width = 16,
                          .height = 16,
                          .duration = microseconds(10'000),
                          .start = microseconds(std::int64_t{1} << 61),
                          .first_rate_hz = 128'000,
                          .last_rate_hz = 128'000,
                          .amplitude_px = 1000.0});
  expect_a_function_of_seed_and_start<FlightOverChairs>(
      FlightOverChairsConfig{.duration = microseconds(500'000)});
  expect_a_function_of_seed_and_start<FlightOverChairs>(
      FlightOverChairsConfig{.width = 120,
                             .height = 700,
                             .duration = microseconds(3'000'001),
                             .start = microseconds(-77),
                             .chair_px = 60.0});
}

// Of two equal streams, one of which is moved between two reads.
template <class Stream>
void expect_the_same_after_a_move(Stream stream, Stream twin) {
  EXPECT_EQ(read_events(stream, 1'000), read_events(twin, 1'000));
  Stream moved(std::move(stream));
  EXPECT_EQ(read_events(moved, 1'000), read_events(twin, 1'000));
  stream = std::move(moved);
  const std::vector<Event> events = read_events(stream, 1'000);
  EXPECT_FALSE(events.empty());
  EXPECT_EQ(events, read_events(twin, 1'000));
}

TEST(EventStream, AMoveKeepsTheState) {
  expect_the_same_after_a_move(ShakenPattern{}, ShakenPattern{});
  expect_the_same_after_a_move(FlightOverChairs{}, FlightOverChairs{});
}

}  // namespace
}  // namespace asap::streams_test
