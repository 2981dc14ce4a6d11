#include "asap/runner/tiled.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/event_surface.hpp"
#include "asap/algorithms/noise_filters.hpp"
#include "asap/algorithms/plane_flow.hpp"
#include "support/allocation_counter.hpp"

#if defined(__linux__)
#include <pthread.h>
#endif

namespace asap::tiled_test {
namespace {

struct FlowAsPublished : PlaneFlow {
  using PlaneFlow::PlaneFlow;
};

// A user's: how many events of the three rows around came before, at the same stamp or later ones.
class Neighbours {
 public:
  struct Config {
    int width;
    int height;
  };
  using Answer = std::int64_t;

  explicit Neighbours(const Config& config)
      : config_(config), rows_(static_cast<std::size_t>(config.height) + 2) {}

  static int reach(const Config&) { return 1; }

  void process(EventSpan events) {
    std::vector<Answer> unused(events.size());
    process(events, unused);
  }
  void process(EventSpan events, std::span<Answer> answers) {
    for (std::size_t i = 0; i < events.size(); ++i) {
      const Event& event = events[i];
      answers[i] = 0;
      if (event.x >= config_.width || event.y >= config_.height) {
        ++rejected_;
        continue;
      }
      if (event.p == 7) throw std::runtime_error("seven");
      ++rows_[event.y + 1U];
      answers[i] = rows_[event.y] + 1000 * rows_[event.y + 1U] + 1'000'000 * rows_[event.y + 2U];
    }
  }
  void set_gamma(double) {}
  void reset() {
    std::fill(rows_.begin(), rows_.end(), 0);
    rejected_ = 0;
  }
  std::uint64_t rejected() const { return rejected_; }
  const Config& config() const { return config_; }

 private:
  Config config_;
  std::vector<Answer> rows_;
  std::uint64_t rejected_ = 0;
};

// Those of a user who looks at the last event of a call.
struct NeverIdle : Neighbours {
  using Neighbours::Neighbours;
  void process(EventSpan events, std::span<Answer> answers) {
    if (events.empty()) throw std::logic_error("called without an event");
    Neighbours::process(events, answers);
  }
};
struct ReachesBack : Neighbours {
  using Neighbours::Neighbours;
  static int reach(const Config&) { return -1; }
};

template <class A>
typename A::Config sized(int width, int height) {
  typename A::Config config{.width = width, .height = height};
  if constexpr (std::is_same_v<A, FlowAsPublished>) config.refit = true;
  if constexpr (std::is_same_v<A, PlaneFlow>) config.min_points = 5;
  return config;
}

// All that an algorithm has said of a stream, as bytes.
class Said {
 public:
  template <class A>
  void process(A& algorithm, EventSpan events) {
    if constexpr (requires { algorithm.copy_to(std::span(bytes_)); }) {
      algorithm.process(events);
      bytes_.resize(static_cast<std::size_t>(algorithm.config().width * algorithm.config().height));
      algorithm.copy_to(std::span(bytes_));
    } else if constexpr (requires { algorithm.process(events, std::span<Event>()); }) {
      std::vector<Event> passed(events.begin(), events.end());
      passed.resize(algorithm.process(passed, std::span(passed)));  // in place
      for (const Event& event : passed) {
        add(event.x), add(event.y), add(event.p), add(event.t);
      }
    } else {
      std::vector<typename A::Answer> answers(events.size());
      algorithm.process(events, std::span(answers));
      for (const auto& answer : answers) add(answer);
    }
  }

  friend bool operator==(const Said&, const Said&) = default;

 private:
  template <class Value>
  void add(const Value& value) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof value);
  }

  std::vector<std::uint8_t> bytes_;
};

bool is_long() { return std::getenv("ASAP_LONG_TESTS") != nullptr; }

// In packages of random sizes; gamma changes on the way.
template <class A>
Said said_by(A& algorithm, EventSpan events, std::uint64_t seed) {
  const CounterRandom random(seed);
  Said said;
  for (std::uint64_t i = 0; !events.empty(); ++i) {
    const std::uint64_t bits = random(i);
    if (bits % 5 == 0) algorithm.set_gamma(static_cast<double>(bits >> 32) / 4294967296.0);
    const std::size_t size = std::min(events.size(), (bits >> 8) % (std::size_t{1} << bits % 13));
    said.process(algorithm, events.first(size));
    events = events.subspan(size);
  }
  return said;
}

template <class A>
class TiledAlgorithm : public testing::Test {
 protected:
  static void is_as_one(int width, int height, int threads, EventSpan events, std::uint64_t seed) {
    const auto config = sized<A>(width, height);
    A one(config);
    Tiled<A> tiled(config, {.threads = threads});
    for (int round = 0; round < 2; ++round) {  // the second time after reset()
      const Said expected = said_by(one, events, seed);
      ASSERT_TRUE(said_by(tiled, events, seed) == expected)
          << width << " x " << height << ", " << threads << " threads, seed " << seed;
      ASSERT_EQ(tiled.rejected(), one.rejected());
      one.reset();
      tiled.reset();
      ASSERT_EQ(tiled.rejected(), 0U);
    }
  }
};

using Algorithms = testing::Types<EFast, ArcStar, EHarris, FAHarris, PlaneFlow, FlowAsPublished,
                                  BackgroundActivityFilter, ThresholdOrdinalSurface, Neighbours>;
TYPED_TEST_SUITE(TiledAlgorithm, Algorithms);

TYPED_TEST(TiledAlgorithm, IsAsOneInstance) {
  const std::uint64_t rounds = is_long() ? 300 : 18;
  for (std::uint64_t seed = 0; seed < rounds; ++seed) {
    const std::uint64_t bits = CounterRandom(seed)(0);
    const int width = 12 + static_cast<int>(bits % 60);
    const int height = 1 + static_cast<int>((bits >> 16) % 300);
    const auto events = test::wild_stream({.width = width, .height = height, .seed = seed}, 8'000);
    this->is_as_one(width, height, 1 + static_cast<int>(seed % 9), events, seed);
  }
}

// Steps back of any size, stamps far ahead, events outside the frame, other polarities.
TYPED_TEST(TiledAlgorithm, IsAsOneInstanceOnJaggedStamps) {
  constexpr int kWidth = 24;
  constexpr int kHeight = 120;
  for (std::uint64_t seed = 1; seed <= (is_long() ? 100U : 6U); ++seed) {
    const CounterRandom random(seed);
    auto events = test::wild_stream(
        {.width = kWidth, .height = kHeight, .start_us = seed % 2 == 0 ? 0 : -40'000, .seed = seed},
        10'000);
    for (std::uint64_t i = 1; i < events.size(); ++i) {
      const std::uint64_t bits = random(i);
      Event& event = events[i];
      const std::int64_t steps[] = {-1,
                                    -30,
                                    0,
                                    50'000,
                                    -900'000,
                                    -2'000'000,
                                    3'000'000'000,
                                    -(std::int64_t{1} << 50),
                                    std::int64_t{1} << 51};
      event.t = events[i - 1].t + (event.t - events[i - 1].t) % 100;
      if (bits % 8 == 0) event.t += steps[(bits >> 8) % (bits % 64 == 0 ? 9 : 5)];
      if (bits % 128 == 1) event.x = kWidth;
      if (bits % 128 == 2) event.y = kHeight + 5;
      if (bits % 128 == 3) event.t = std::numeric_limits<std::int64_t>::max() / 2;
    }
    this->is_as_one(kWidth, kHeight, 2 + static_cast<int>(seed % 4), events, seed);
  }
}

// Each thread sees a half: what no half shows alone. The fifth package is the first that all take.
TYPED_TEST(TiledAlgorithm, IsAsOneInstanceWhereTwoHalvesOfAPackageMeet) {
  constexpr std::size_t kSize = 1'000;
  const auto events = test::wild_stream({.width = 24, .height = 120}, 6 * kSize);
  for (int fault = 0; fault < 5; ++fault) {
    auto jagged = events;
    const auto second = std::span(jagged).subspan(4 * kSize);
    Event& ahead = second[kSize / 2 - 2];  // in the first half, and what only the upper band sees
    Event& last = second[kSize / 2 - 1];
    if (fault == 1 || fault == 2) {
      ahead.y = last.y = 0;
      ahead.t = last.t += 200'000;
    }
    if (fault == 2) last.y = 120, last.t -= 1'000'000;
    if (fault == 3) {
      for (Event& event : second) event.t += std::int64_t{1} << 51;
      second[kSize - 1].y = 120, second[kSize - 1].t = 0;
    }
    if (fault == 4) {  // as far ahead as can be
      using Stamps = std::numeric_limits<std::int64_t>;
      const std::int64_t last_us = events.back().t;
      for (Event& event : jagged) event.t += Stamps::min();
      for (Event& event : second) event.t = Stamps::max() - (last_us - (event.t - Stamps::min()));
    }
    const auto config = sized<TypeParam>(24, 120);
    TypeParam one(config);
    Tiled<TypeParam> tiled(config, {.threads = 2});
    Said expected;
    Said said;
    for (std::size_t i = 0; i < jagged.size(); i += kSize) {
      expected.process(one, EventSpan(jagged).subspan(i, kSize));
      said.process(tiled, EventSpan(jagged).subspan(i, kSize));
    }
    EXPECT_TRUE(said == expected) << "fault " << fault;
    EXPECT_EQ(tiled.rejected(), one.rejected());
  }
}

TYPED_TEST(TiledAlgorithm, IsAsOneInstanceOverASilenceOrAStampFarAhead) {
  constexpr int kWidth = 16;
  constexpr int kHeight = 100;
  const auto events = test::wild_stream({.width = kWidth, .height = kHeight}, 4'000);
  constexpr std::int64_t kMinute_us = 60'000'000;
  for (const std::int64_t gap_us :
       {36 * kMinute_us, std::int64_t{1} << 32, std::int64_t{1} << 50, -(std::int64_t{1} << 50)}) {
    for (const std::int64_t ahead_us : {std::int64_t{0}, 72 * kMinute_us}) {
      auto both = events;
      for (Event event : events) {
        event.t += gap_us;
        both.push_back(event);
      }
      both[events.size() - 1].t += ahead_us;
      // The lower half of the sensor sees nothing of the one far ahead, and little for a long time.
      for (std::size_t i = 0; i + 1 < events.size(); ++i) {
        both[i].y = static_cast<std::uint16_t>(both[i].y % (kHeight / 2));
      }
      this->is_as_one(kWidth, kHeight, 3, both, 1);
    }
  }
}

TYPED_TEST(TiledAlgorithm, AllocatesOnlyInTheConstructor) {
  if constexpr (!std::is_same_v<TypeParam, Neighbours>) {
    const auto events = test::wild_stream({.width = 40, .height = 200}, 40'000);
    Tiled<TypeParam> tiled(sized<TypeParam>(40, 200), {.threads = 3});
    std::vector<Event> passed(events);
    const auto process = [&] {
      if constexpr (std::is_same_v<TypeParam, BackgroundActivityFilter>) {
        tiled.process(events, std::span(passed));
      } else {
        tiled.process(events);
      }
    };
    const std::size_t before = test::allocations();
    for (int i = 0; i < 20; ++i) process();
    tiled.set_gamma(0.5);
    tiled.reset();
    process();
    EXPECT_EQ(test::allocations(), before);
  }
}

TEST(Tiled, TakesAlgorithmsWhoseReachIsKnown) {
  EXPECT_TRUE(Tileable<EFast>);
  EXPECT_FALSE(Tileable<SpeedInvariantTimeSurface>);
  EXPECT_FALSE(Tileable<HotPixelMask>);
}

TEST(Tiled, RefusesBadValues) {
  for (const int threads : {0, -1, 65}) {
    EXPECT_THROW(Tiled<EFast>({.width = 40, .height = 30}, {.threads = threads}),
                 std::invalid_argument);
  }
  EXPECT_THROW(Tiled<EFast>({.width = 0, .height = 30}, {.threads = 2}), std::invalid_argument);
  EXPECT_THROW(Tiled<EFast>({.width = 40, .height = 65'537}, {.threads = 2}),
               std::invalid_argument);
  EXPECT_THROW(
      Tiled<ThresholdOrdinalSurface>({.width = 40, .height = 30, .side = -4}, {.threads = 2}),
      std::invalid_argument);
  Tiled<EFast> tiled({.width = 40, .height = 30}, {.threads = 2});
  EXPECT_THROW(tiled.set_gamma(1.5), std::invalid_argument);
  const std::vector<Event> events(3);
  std::vector<std::uint8_t> two(2);
  EXPECT_THROW(tiled.process(events, std::span(two)), std::invalid_argument);
  EXPECT_THROW(Tiled<ReachesBack>({.width = 40, .height = 30}, {.threads = 2}),
               std::invalid_argument);
  for (const int threads : {1, 2}) {
    const Tiled<ThresholdOrdinalSurface> surface({.width = 40, .height = 30}, {.threads = threads});
    EXPECT_THROW(surface.copy_to(std::span(two)), std::invalid_argument);
  }
}

TEST(Tiled, CallsNoAlgorithmWithoutAnEvent) {
  Tiled<NeverIdle> tiled({.width = 8, .height = 64}, {.threads = 4});
  std::vector<NeverIdle::Answer> answers(1);
  for (int i = 0; i < 200; ++i) {  // by one thread, and by all
    const Event event{.x = 1, .y = static_cast<std::uint16_t>(i % 64), .p = 1, .t = i};
    EXPECT_NO_THROW(tiled.process({&event, 1}, std::span(answers)));
  }
}

TEST(Tiled, WhatAWorkerThrowsComesOutAndTheStateIsLostUntilReset) {
  Tiled<Neighbours> tiled({.width = 8, .height = 64}, {.threads = 4});
  std::vector<Event> events;
  for (std::uint16_t i = 0; i < 20'000; ++i) {
    events.push_back({.x = 0, .y = static_cast<std::uint16_t>(i % 64), .p = 0, .t = i});
  }
  for (const int row : {0, 20, 40, 63}) {
    for (int i = 0; i < 3; ++i) tiled.process(events);  // by one thread, and by all
    auto bad = events;
    Event& event = bad[static_cast<std::size_t>(9000 + row)];
    event.p = 7;
    event.y = static_cast<std::uint16_t>(row);
    EXPECT_THROW(tiled.process(bad), std::runtime_error);
    EXPECT_THROW(tiled.process(events), std::runtime_error) << "the state is lost";
    tiled.reset();
    Neighbours one({.width = 8, .height = 64});
    EXPECT_TRUE(said_by(tiled, events, 1) == said_by(one, events, 1));
  }
}

TEST(Tiled, ItsThreadsStartWithTheHookAndTheirName) {
  std::atomic<int> numbers = 0;
  std::atomic<int> named = 0;
  const Tiled<EFast> tiled({.width = 40, .height = 200},
                           {.threads = 4, .on_worker_start = [&](int number) {
                              numbers += 1 << number;
#if defined(__linux__)
                              char name[16];
                              pthread_getname_np(pthread_self(), name, sizeof name);
                              named += std::string(name) ==
                                       std::string("asap-tiled-").append(std::to_string(number));
#endif
                            }});
  EXPECT_EQ(numbers, 0b1110);
#if defined(__linux__)
  EXPECT_EQ(named, 3);
#endif
}

TEST(Tiled, WhatTheHookThrowsComesOutOfTheConstructor) {
  const auto make = [] {
    const Tiled<EFast> tiled({.width = 40, .height = 200},
                             {.threads = 4, .on_worker_start = [](int number) {
                                if (number == 2) throw std::logic_error("no priority");
                              }});
  };
  EXPECT_THROW(make(), std::logic_error);
}

}  // namespace
}  // namespace asap::tiled_test
