#include "schemes/driver_containers.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/random.hpp"

namespace asap::driver_containers_test {
namespace {

constexpr std::int64_t kMicrosecond = 1000;
constexpr std::int64_t kMillisecond = 1'000'000;

// Remembers when containers were delivered.
class Recorder {
 public:
  void pass(std::size_t count, std::int64_t from_ns, std::int64_t until_ns) {
    containers.pass(count, from_ns, until_ns, [&](std::int64_t time) { times.push_back(time); });
  }

  DriverContainers containers;
  std::vector<std::int64_t> times;
};

using Times = std::vector<std::int64_t>;

TEST(DriverContainers, DeliverAThousandEvents) {
  Recorder recorder;
  EXPECT_EQ(recorder.containers.left(), 1000u);
  recorder.pass(2500, 0, 2500 * kMicrosecond);
  EXPECT_EQ(recorder.times, (Times{999 * kMicrosecond, 1999 * kMicrosecond}));
  EXPECT_EQ(recorder.containers.left(), 500u);
  recorder.pass(500, 2500 * kMicrosecond, 3000 * kMicrosecond);
  EXPECT_EQ(recorder.times.back(), 2999 * kMicrosecond);
  EXPECT_EQ(recorder.containers.left(), 1000u);
}

TEST(DriverContainers, DeliverAfterTwentyMilliseconds) {
  Recorder recorder;
  recorder.pass(50, 0, 50 * kMillisecond);
  EXPECT_EQ(recorder.times, (Times{20 * kMillisecond, 40 * kMillisecond}));
  EXPECT_EQ(recorder.containers.left(), 990u);
}

TEST(DriverContainers, DeliverNothingInSilence) {
  Recorder recorder;
  recorder.pass(1, 0, 0);
  EXPECT_TRUE(recorder.times.empty());
  recorder.pass(1, 1007 * kMillisecond, 1007 * kMillisecond);
  EXPECT_EQ(recorder.times, (Times{20 * kMillisecond}));
  recorder.pass(1, 1019 * kMillisecond, 1019 * kMillisecond);
  EXPECT_EQ(recorder.containers.left(), 998u);
  recorder.pass(1, 1020 * kMillisecond, 1020 * kMillisecond);  // the periods go on in silence
  EXPECT_EQ(recorder.times, (Times{20 * kMillisecond, 1020 * kMillisecond}));
}

TEST(DriverContainers, ManyEventsOnOneStamp) {
  Recorder recorder;
  recorder.pass(1'000'000, 5, 5);
  EXPECT_EQ(recorder.times, Times(1000, 5));
}

TEST(DriverContainers, ABurstAfterALongTimeBegins) {
  constexpr std::int64_t kFarAway = 9'000'000'000'000'000'000;
  Recorder recorder;
  recorder.pass(1, 0, 0);
  recorder.pass(3, 0, kFarAway);
  EXPECT_EQ(recorder.times.size(), 2u);
  EXPECT_EQ(recorder.containers.left(), 999u);
}

// Event by event.
Times delivered(const Times& events_ns) {
  Times times;
  std::int64_t begin_ns = events_ns.front();
  std::size_t held = 0;
  for (const std::int64_t t : events_ns) {
    while (t >= begin_ns + 20 * kMillisecond) {
      begin_ns += 20 * kMillisecond;
      if (held > 0) times.push_back(begin_ns);
      held = 0;
    }
    if (++held < 1000) continue;
    held = 0;
    begin_ns = t;
    times.push_back(t);
  }
  return times;
}

TEST(DriverContainers, AgreeWithACountEventByEvent) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(seed);
    Recorder recorder;
    Times events_ns;
    std::int64_t from_ns = 1000 * static_cast<std::int64_t>(seed);
    for (std::uint64_t k = 0; k < 200; ++k) {
      const auto count = static_cast<std::int64_t>(1 + random(3 * k) % 3000);
      const std::int64_t steps_ns[] = {0, 700, 40'000, 90'000'000};
      const std::int64_t step_ns = steps_ns[random(3 * k + 1) % 4];
      const std::int64_t size = step_ns > 1'000'000 ? 1 + count % 5 : count;
      for (std::int64_t i = 0; i < size; ++i) events_ns.push_back(from_ns + i * step_ns);
      const std::int64_t until_ns = from_ns + size * step_ns;
      recorder.pass(static_cast<std::size_t>(size), from_ns, until_ns);
      from_ns = until_ns;
    }
    EXPECT_EQ(recorder.times, delivered(events_ns)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace asap::driver_containers_test
