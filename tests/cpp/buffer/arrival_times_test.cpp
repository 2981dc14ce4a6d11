#include "buffer/arrival_times.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "core/random.hpp"
#include "support/errors.hpp"

namespace asap::arrival_times_test {
namespace {

constexpr std::size_t kSteps = ArrivalTimes::kSteps;

TEST(ArrivalTimes, CountsForManyTimesAtOnceAsForEach) {
  const CounterRandom random(1);
  std::uint64_t draws = 0;
  const auto draw = [&](std::uint64_t max) { return random(draws++) % (max + 1); };
  for (int round = 0; round < 300; ++round) {
    ArrivalTimes times(10);
    std::uint64_t index = 0;
    std::int64_t now_ns = 0;
    for (std::uint64_t steps = draw(200); steps > 0; --steps) {
      times.note(index, now_ns);
      index += 1 + draw(20);
      now_ns += static_cast<std::int64_t>(draw(5) == 0 ? draw(2000) : draw(30));
    }
    const std::uint64_t head = draw(index);
    times.release(head);
    const auto step_ns = static_cast<std::int64_t>(1 + draw(100));
    std::vector<std::size_t> counts(32);
    times.before_each(now_ns, step_ns, head, index - head, counts);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const std::int64_t time_ns = now_ns - static_cast<std::int64_t>(i) * step_ns;
      ASSERT_EQ(counts[i], times.before(time_ns, head, index - head)) << round << ", " << i;
    }
  }
}

TEST(ArrivalTimes, ABacklogOfAnyLengthKeepsItsAgesToAFewPercent) {
  constexpr std::int64_t kEnd = 4'000'000;
  ArrivalTimes times(10);
  std::vector<std::int64_t> pushed;
  for (std::int64_t now = 0; now < kEnd; now += 10) {
    times.note(pushed.size(), now);
    pushed.push_back(now);
  }
  for (std::size_t i = 0; i < pushed.size(); ++i) {
    ASSERT_LE(times.of(i), pushed[i]) << "never younger than it is";
    ASSERT_LE(pushed[i] - times.of(i), pushed[i] / 100);
  }
}

TEST(ArrivalTimes, ASmallRingHasASmallTable) {
  EXPECT_EQ(ArrivalTimes::steps_for(std::size_t{1} << 20), kSteps);
  EXPECT_EQ(ArrivalTimes::steps_for(std::size_t{1} << 17), 4096u);
  EXPECT_EQ(ArrivalTimes::steps_for(std::size_t{1} << 16), 2048u);
  EXPECT_EQ(ArrivalTimes::steps_for(1), 2048u);
  ArrivalTimes times(10, ArrivalTimes::steps_for(1));
  std::uint64_t index = 0;
  for (std::int64_t now = 0; now < 4'000'000; now += 10) times.note(index++, now);
  for (std::uint64_t i = 0; i < index; ++i) {
    const auto pushed = static_cast<std::int64_t>(10 * i);
    ASSERT_LE(times.of(i), pushed) << "never younger than it is";
    ASSERT_LE(pushed - times.of(i), pushed / 50);
  }
}

TEST(ArrivalTimes, AFullTableGoesOnWithItsLastStep) {
  ArrivalTimes times(1);
  std::uint64_t index = 0;
  std::int64_t now = 0;
  for (; index < 2 * kSteps; ++index) times.note(index, now += std::int64_t{1} << 20);
  EXPECT_EQ(times.of(0), std::int64_t{1} << 20);
  EXPECT_EQ(times.of(index - 1), times.of(kSteps - 1));
  times.release(index - 1);
  times.note(index, now += 10);
  EXPECT_EQ(times.of(index), now);
}

TEST(ArrivalTimes, RefusesAStepOutOfRange) {
  EXPECT_EQ(test::error_of([] { ArrivalTimes times(0); }),
            "step_ns = 0: must be between 1 ns and 10^12 ns");
}

}  // namespace
}  // namespace asap::arrival_times_test
