// In real time, on a machine that may take the processor away from a thread for a second: what is
// exact here never depends on how soon a thread has its turn.
#include "asap/runner/replay.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "runner/run.hpp"
#include "support/errors.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

#if defined(__linux__)
#include <sys/prctl.h>
#endif

namespace asap::replay_test {
namespace {

using test::at_times;
using test::evenly_spaced;
using test::Events;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::int64_t kHour_us = 3'600'000'000;

struct Trouble {
  int code;
};

// The code of the Trouble that a call ends with; 0: none.
template <class Action>
int trouble_of(Action&& action) {
  try {
    action();
  } catch (const Trouble& trouble) {
    return trouble.code;
  }
  return 0;
}

// Events in chunks, with trouble at the end.
class TroubledSource final : public EventSource {
 public:
  TroubledSource(EventSpan events, std::size_t chunk) : events_(events), chunk_(chunk) {}

  EventSpan next() override {
    if (events_.empty()) throw Trouble{3};
    const EventSpan chunk = events_.first(std::min(chunk_, events_.size()));
    events_ = events_.subspan(chunk.size());
    return chunk;
  }

 private:
  EventSpan events_;
  std::size_t chunk_;
};

// One chunk, then nothing, neither events nor the end, until it is cancelled.
class SilentSource final : public EventSource {
 public:
  explicit SilentSource(EventSpan events) : first_(events) {}

  EventSpan next() override {
    if (!first_.empty()) return std::exchange(first_, {});
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return cancelled_; });
    return {};
  }
  void cancel() noexcept override {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = true;
    }
    changed_.notify_all();
  }

 private:
  EventSpan first_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool cancelled_ = false;
};

TEST(Replay, DeliversEveryEventInOrder) {
  const Events events = test::random_stream(1, 20'000, 1'600'000'000'000'000);
  Asap2020 scheme({.rate_bound = 1e9, .first_size = 50});
  Replay replay(scheme, {.speed = 50});
  SpanSource source(events);
  Events delivered;
  replay.run(source, [&](EventSpan package) {
    delivered.insert(delivered.end(), package.begin(), package.end());
  });
  EXPECT_EQ(delivered, events);
  EXPECT_EQ(replay.ledger(), (Ledger{.received = 20'000, .delivered = 20'000}));
  const RunStats stats = replay.stats();
  EXPECT_EQ(stats.latency.count(), 20'000u);
  EXPECT_EQ(stats.packages.count, replay.log().size());
  EXPECT_EQ(stats.packages.size, 20'000u);
  EXPECT_FALSE(stats.failed);
}

TEST(Replay, AnAlgorithmThatIsNoneIsRefusedBeforeTheRun) {
  const Events events = evenly_spaced(10, 30);
  FixedSize scheme;
  Replay replay(scheme);
  SpanSource source(events);
  EXPECT_EQ(test::error_of([&] { replay.run(source, {}); }),
            "algorithm = none: give what the events are for");
  replay.run(source, [](EventSpan) {});
  EXPECT_EQ(replay.ledger().delivered, 10u);
}

TEST(Replay, APackageStartsAfterItsEventsHaveArrived) {
  const Events events = evenly_spaced(5000, 40, 1'600'000'000'123'456);
  FixedSize scheme({.size = 100});
  Replay replay(scheme, {.speed = 4});
  SpanSource source(events);
  replay.run(source, [](const Package&) {});
  const RunLog& log = replay.log();
  ASSERT_GE(log.size(), 50u);
  for (std::size_t i = 0; i < log.size(); ++i) {
    EXPECT_GE(log[i].start_us, static_cast<double>(log[i].t_last));
    EXPECT_GE(log[i].latency_max_us, log[i].processing_us);
  }
}

// Everything that waits, in packages that are to end in time.
test::ScriptedScheme::Rule all_within(std::int64_t budget_ns) {
  return [=](const Backlog& backlog) {
    Decision decision = Decision::take(backlog.count);
    decision.budget_ns = budget_ns;
    decision.event_ns = 2000;
    return decision;
  };
}

// A callable that costs 50 us per call would cost 800 us per package in sixteen parts.
TEST(Replay, ACallableGetsAPackageInOneCallUnlessItAsksForParts) {
  const Events events = evenly_spaced(100'000, 1);
  for (const Execution execution : {RunConfig{}.execution, Execution::anytime}) {
    test::ScriptedScheme scheme(all_within(60'000'000'000));
    Replay replay(scheme, {}, {.execution = execution});
    SpanSource source(events);
    std::size_t calls = 0;
    replay.run(source, [&](const Package&) {
      ++calls;
      std::this_thread::sleep_for(2ms);  // so that the next package is large
    });
    const std::size_t packages = replay.log().size();
    EXPECT_EQ(calls == packages, execution == Execution::whole) << calls << ", " << packages;
  }
}

// Its second chunk comes once the algorithm has had the first.
class StepSource final : public EventSource {
 public:
  EventSpan next() override {
    if (chunk_ == 2) return {};
    if (chunk_ == 1) {
      std::unique_lock lock(mutex_);
      was_seen_in_time = changed_.wait_for(lock, 60s, [this] { return seen_; });
    }
    return {&events_[chunk_++], 1};
  }

  void see() {
    {
      const std::lock_guard lock(mutex_);
      seen_ = true;
    }
    changed_.notify_all();
  }

  bool was_seen_in_time = false;

 private:
  const Events events_ = evenly_spaced(2, 10);
  std::size_t chunk_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool seen_ = false;
};

TEST(Replay, DeliversWhatHasComeWhileTheSourceIsSilent) {
  Greedy scheme;
  Replay replay(scheme, {}, {});
  StepSource source;
  replay.run(source, [&](const Package&) { source.see(); });
  EXPECT_TRUE(source.was_seen_in_time);
  EXPECT_EQ(replay.ledger().delivered, 2u);
}

TEST(Replay, AnExceptionOfTheSourceComesOutWhenAllIsDelivered) {
  const Events events = evenly_spaced(1000, 20);
  Greedy scheme;
  Replay replay(scheme);
  TroubledSource source(events, 300);
  EXPECT_EQ(trouble_of([&] { replay.run(source, [](const Package&) {}); }), 3);
  EXPECT_EQ(replay.ledger(), (Ledger{.received = 1000, .delivered = 1000}));
}

TEST(Replay, AValidatorThatRefusesLeavesABalancedLedger) {
  Events events = evenly_spaced(1000, 20);
  events[700].t = 0;
  Greedy scheme;
  Replay replay(scheme, {}, {.validator = {.on_bad = OnBad::raise}});
  SpanSource source(events);
  const std::string error = test::error_of([&] { replay.run(source, [](const Package&) {}); });
  EXPECT_EQ(error.substr(0, 19), "t = 0 (event 700): ");
  EXPECT_EQ(replay.ledger(), (Ledger{.received = 701, .rejected = 1, .delivered = 700}));
}

// Returns the code of the trouble that the callback makes after two events.
int trouble_after_two(Replay& replay, EventSource& source) {
  return trouble_of([&] {
    replay.run(
        source, [](const Package&) {},
        [&] {
          if (replay.ledger().delivered == 2) throw Trouble{9};
        });
  });
}

TEST(Replay, StopsWhileTheNextEventIsAnHourAway) {
  const Events events = at_times({0, 10, 20 + kHour_us, 30 + kHour_us});
  Greedy scheme;
  Replay replay(scheme);
  SpanSource source(events);
  EXPECT_EQ(trouble_after_two(replay, source), 9);
  EXPECT_EQ(replay.ledger(), (Ledger{.received = 4, .delivered = 2, .pending = 2}));
}

TEST(Replay, StopsWhileTheSourceIsSilent) {
  const Events events = at_times({0, 10});
  Greedy scheme;
  Replay replay(scheme);
  SilentSource source(events);
  EXPECT_EQ(trouble_after_two(replay, source), 9);
  EXPECT_TRUE(replay.ledger().balanced());
}

TEST(Replay, ASlowAlgorithmDoesNotDelayTheProducer) {
  const Events events = evenly_spaced(5000, 20);  // 100 ms
  SingleEvent scheme;
  Replay replay(scheme, {}, {.capacity = 64});
  SpanSource source(events);
  bool first = true;
  const auto until = Steady::now() + 120s;
  replay.run(source, [&](const Package&) {
    if (!std::exchange(first, false)) return;
    while (replay.ledger().received < 5000 && Steady::now() < until) {
      std::this_thread::sleep_for(1ms);
    }
    EXPECT_EQ(replay.ledger().received, 5000u) << "it pushes while the algorithm works";
  });
  const Ledger ledger = replay.ledger();
  EXPECT_EQ(ledger.received, 5000u);
  EXPECT_GE(ledger.overflow, 4000u);
  EXPECT_EQ(ledger.delivered + ledger.overflow, 5000u);
  // What was lost until the first package was done is told with it and the next one.
  const RunLog& log = replay.log();
  EXPECT_EQ(static_cast<std::uint64_t>(log[0].overflow + log[1].overflow), ledger.overflow);
}

TEST(Replay, PollsWhileTheAlgorithmIsBusyAndWhileNothingComes) {
  const Events events = evenly_spaced(60, 1000);
  SingleEvent scheme;
  Replay replay(scheme);
  SilentSource source(events);
  int busy = 0;
  int idle = 0;
  const int code = trouble_of([&] {
    replay.run(
        source, [](const Package&) { std::this_thread::sleep_for(2ms); },
        [&] {
          ++(replay.ledger().delivered < 60 ? busy : idle);
          if (idle == 2) throw Trouble{9};
        });
  });
  EXPECT_EQ(code, 9) << "or it waits for ever";
  EXPECT_GE(busy, 2);
}

TEST(Replay, RunsOnce) {
  const Events events = evenly_spaced(60, 1);
  Greedy scheme;
  Replay replay(scheme);
  SpanSource source(events);
  replay.run(source, [](EventSpan) {});
  SpanSource again(events);
  EXPECT_THROW(replay.run(again, [](EventSpan) {}), std::logic_error);
  EXPECT_EQ(replay.ledger(), (Ledger{.received = 60, .delivered = 60}));
}

#if defined(__linux__)
TEST(Replay, SleepsAsExactlyAsTheKernelCan) {
  struct Asking final : EventSource {
    EventSpan next() override {
      slack_ns = prctl(PR_GET_TIMERSLACK);
      return {};
    }
    int slack_ns = 0;
  } source;
  Greedy scheme;
  Replay(scheme).run(source, [](EventSpan) {});
  EXPECT_EQ(source.slack_ns, 1);
}
#endif

TEST(Replay, RefusesABadConfigurationByName) {
  Greedy scheme;
  const auto error = [&](ReplayConfig config) {
    return test::error_of([&] { Replay replay(scheme, config); });
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error({.speed = 0}), "speed = 0: must be between 0.001 and 1e6");
  EXPECT_EQ(error({.speed = -1}), "speed = -1: must be between 0.001 and 1e6");
  EXPECT_EQ(error({.speed = kNaN}), "speed = nan: must be between 0.001 and 1e6");
  EXPECT_EQ(error({.pacing = -1us}), "pacing = -1 us: must be between 0 and 1000 us");
  EXPECT_EQ(error({.pacing = 1s}), "pacing = 1000000 us: must be between 0 and 1000 us");
}

}  // namespace
}  // namespace asap::replay_test
