#include "synthetic/block.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace asap::block_test {
namespace {

// ---- TimeSortedBlock ------------------------------------------------------------------------

std::vector<Event> closed(TimeSortedBlock& block) {
  const EventSpan events = block.close();
  return {events.begin(), events.end()};
}

TEST(TimeSortedBlock, SortsByTimeAndKeepsTheOrderOfEqualTimes) {
  TimeSortedBlock block{10, 10, 4};
  block.open(1000, 20);
  block.add(1, 2, true, 19);
  block.add(3, 4, false, 0);
  block.add(5, 6, true, 7);
  block.add(7, 8, false, 7);
  EXPECT_EQ(
      closed(block),
      (std::vector<Event>{{3, 4, 0, 1000}, {5, 6, 1, 1007}, {7, 8, 0, 1007}, {1, 2, 1, 1019}}));
}

TEST(TimeSortedBlock, DoesNotSeeWhatLiesOutsideTheSensor) {
  TimeSortedBlock block{10, 8, 8};
  block.open(0, 1);
  block.add(-1, 0, true, 0);
  block.add(0, -1, true, 0);
  block.add(10, 0, true, 0);
  block.add(0, 8, true, 0);
  block.add(9, 7, true, 0);
  EXPECT_EQ(closed(block), (std::vector<Event>{{9, 7, 1, 0}}));
}

TEST(TimeSortedBlock, StartsEmptyAtEveryStep) {
  TimeSortedBlock block{10, 10, 2};
  block.open(0, TimeSortedBlock::kMaxStep_us);
  block.add(1, 1, true, TimeSortedBlock::kMaxStep_us - 1);
  EXPECT_EQ(block.close().size(), 1U);
  block.open(-500, 3);
  EXPECT_TRUE(block.close().empty());
  block.open(-500, 3);
  block.add(2, 2, false, 2);
  EXPECT_EQ(closed(block), (std::vector<Event>{{2, 2, 0, -498}}));
}

// ---- BackgroundNoise ------------------------------------------------------------------------

std::vector<Event> noise_of(std::int32_t width, std::int32_t height, double noise_hz,
                            std::uint64_t seed, std::int64_t duration_us, std::int32_t step_us) {
  const BackgroundNoise noise{width, height, noise_hz, seed};
  TimeSortedBlock block{width, height, TimeSortedBlock::kMaxStep_us};
  std::vector<Event> events;
  for (std::int64_t elapsed_us = 0; elapsed_us < duration_us; elapsed_us += step_us) {
    block.open(elapsed_us, step_us);
    noise.add_to(block, elapsed_us);
    const EventSpan step = block.close();
    events.insert(events.end(), step.begin(), step.end());
  }
  return events;
}

TEST(BackgroundNoise, HasTheRateThatWasAskedForAndSpreadsOverPixelsAndPolarities) {
  const double expected = 50.0 * 20 * 10 * 2.0;  // 50 Hz, 20 x 10 px, 2 s
  const auto events = noise_of(20, 10, 50.0, 7, 2'000'000, 1000);
  EXPECT_NEAR(static_cast<double>(events.size()), expected, 5.0 * std::sqrt(expected));

  std::array<std::array<int, 2>, 200> counts{};
  for (const Event& event : events) {
    ++counts.at(event.x + 20U * event.y).at(static_cast<std::size_t>(event.p));
  }
  for (const auto& pixel : counts) {
    for (const int count : pixel) EXPECT_NEAR(count, 50.0, 5.0 * std::sqrt(50.0));
  }
}

TEST(BackgroundNoise, DependsOnTheMicrosecondNotOnTheStep) {
  const auto events = noise_of(20, 10, 50.0, 7, 100'000, 1000);
  EXPECT_FALSE(events.empty());
  EXPECT_EQ(noise_of(20, 10, 50.0, 7, 100'000, 250), events);
  EXPECT_NE(noise_of(20, 10, 50.0, 8, 100'000, 250), events);
}

TEST(BackgroundNoise, NoneIsNone) { EXPECT_TRUE(noise_of(20, 10, 0.0, 7, 100'000, 1000).empty()); }

TEST(BackgroundNoise, RefusesARateThatItCannotGive) {
  EXPECT_THROW(BackgroundNoise(100, 100, -0.1, 0), std::invalid_argument);
  EXPECT_THROW(BackgroundNoise(100, 100, 100.5, 0), std::invalid_argument);
  EXPECT_THROW(BackgroundNoise(100, 100, std::numeric_limits<double>::quiet_NaN(), 0),
               std::invalid_argument);
  EXPECT_NO_THROW(BackgroundNoise(100, 100, 100.0, 0));
}

}  // namespace
}  // namespace asap::block_test
