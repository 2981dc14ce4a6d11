#include "asap/runner/simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap::simulator_test {
namespace {

using namespace std::chrono_literals;

using test::at_times;
using test::evenly_spaced;
using test::Events;
using test::number_of;

constexpr std::int64_t kUnix_us = 1'600'000'000'000'000;
constexpr std::int64_t kHour_us = 3'600'000'000;

struct Row {
  double start_us;
  double processing_us;
  std::int64_t t_first;
  std::int64_t t_last;
  std::int64_t size;

  friend bool operator==(const Row&, const Row&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Row& row) {
    return out << row.start_us << " + " << row.processing_us << " us: " << row.size << " events "
               << row.t_first << ".." << row.t_last;
  }
};

std::vector<Row> rows_of(const Simulator& simulator) {
  std::vector<Row> rows;
  const RunLog& log = simulator.log();
  for (std::size_t i = 0; i < log.size(); ++i) {
    rows.push_back(
        {log[i].start_us, log[i].processing_us, log[i].t_first, log[i].t_last, log[i].size});
  }
  return rows;
}

// A package of n events costs 100 + 10 n us.
LinearCost slow() { return LinearCost({.alpha_us = 100, .beta_ns = 10'000}); }

std::vector<Row> simulate(Scheme& scheme, EventSpan events, RunConfig config = {}) {
  Simulator simulator(scheme, slow(), config);
  simulator.feed(events);
  simulator.finish();
  EXPECT_TRUE(simulator.ledger().balanced());
  EXPECT_EQ(simulator.ledger().pending, 0u);
  return rows_of(simulator);
}

// ---- small runs, worked out by hand

const Events kSmall = at_times({0, 50, 60, 70, 500, 900});

TEST(Simulator, FixedSizeByHand) {
  FixedSize scheme({.size = 2});
  EXPECT_EQ(
      simulate(scheme, kSmall),
      (std::vector<Row>{{50, 120, 0, 50, 2}, {170, 120, 60, 70, 2}, {900, 120, 500, 900, 2}}));
}

TEST(Simulator, APackageInWorkHoldsItsPlaceInTheRing) {
  SingleEvent scheme;
  Simulator simulator(scheme, slow(), {.capacity = 2});
  simulator.feed(at_times({0, 50, 60, 70, 200, 300}));
  simulator.finish();
  // 0 is in work until 110 and 50 waits: 60 and 70 do not fit. 200 waits behind 50, in work from
  // 110 to 220, and so does 300 behind 200.
  EXPECT_EQ(rows_of(simulator), (std::vector<Row>{{0, 110, 0, 0, 1},
                                                  {110, 110, 50, 50, 1},
                                                  {220, 110, 200, 200, 1},
                                                  {330, 110, 300, 300, 1}}));
  EXPECT_EQ(simulator.log()[1].overflow, 2);
  EXPECT_EQ(simulator.ledger(), (Ledger{.received = 6, .overflow = 2, .delivered = 4}));
}

TEST(Simulator, ASchemeServesOneRunAtATime) {
  Greedy scheme;
  Simulator first(scheme, slow());
  Simulator second(scheme, slow());
  first.feed(kSmall);
  EXPECT_THROW(second.feed(kSmall), std::logic_error);
  EXPECT_THROW(Simulator(scheme, slow()), std::logic_error);
  first.finish();
  second.feed(kSmall);
  second.finish();
  EXPECT_EQ(rows_of(first), rows_of(second));
  const auto fail = [](std::size_t, double) -> double { throw std::runtime_error("no cost"); };
  Simulator failed(scheme, fail);
  EXPECT_THROW(failed.feed(kSmall), std::runtime_error);
  EXPECT_NO_THROW(Simulator(scheme, slow()));
}

TEST(Simulator, OfNothingIsNothing) {
  Greedy scheme;
  EXPECT_TRUE(simulate(scheme, {}).empty());
  Simulator never_fed(scheme, slow());
  EXPECT_EQ(never_fed.ledger(), Ledger{});
}

TEST(Simulator, A10_AHugeGapCostsNothingAndLeavesNoBacklog) {
  FixedSize scheme({.size = 2});
  EXPECT_EQ(
      simulate(scheme, at_times({0, 10, 20, 30 + 10 * kHour_us, 40 + 10 * kHour_us})),
      (std::vector<Row>{{10, 120, 0, 10, 2},
                        {10'020, 110, 20, 20, 1},
                        {40 + 10.0 * kHour_us, 120, 30 + 10 * kHour_us, 40 + 10 * kHour_us, 2}}));
}

TEST(Simulator, AbsurdCostsEndAtTheEndOfTime) {
  SingleEvent scheme;
  Simulator simulator(scheme, LinearCost({.alpha_us = 1e9, .beta_ns = 1e9, .noise = 5}));
  simulator.feed(evenly_spaced(100'000, 1'000'000));
  simulator.finish();
  EXPECT_TRUE(simulator.ledger().balanced());
  EXPECT_EQ(simulator.ledger().pending, 0u);
}

TEST(Simulator, EveryPackageHasACostOfItsOwn) {
  SingleEvent scheme;
  Simulator simulator(scheme, LinearCost({.alpha_us = 100, .beta_ns = 0, .noise = 0.5}));
  simulator.feed(evenly_spaced(100, 10'000));
  simulator.finish();
  std::set<double> costs_us;
  for (const Row& row : rows_of(simulator)) costs_us.insert(row.processing_us);
  EXPECT_EQ(costs_us.size(), 100u);
}

// A table of ages, a rate or a count of 32 bits that such a silence wraps would show in what comes
// after it.
TEST(Simulator, TenHoursWithLongSilencesChangeNothing) {
  constexpr std::int64_t kMinute_us = 60'000'000;
  const Events burst = evenly_spaced(2000, 20);
  const std::vector<std::function<std::unique_ptr<Scheme>()>> schemes{
      [] { return std::make_unique<FixedSize>(FixedSizeConfig{.size = 37}); },
      [] { return std::make_unique<FixedTime>(FixedTimeConfig{.period = 700us}); },
      [] { return std::make_unique<FixedTime>(FixedTimeConfig{.period = 20ms}); },
      [] { return std::make_unique<SingleEvent>(); },
      [] { return std::make_unique<Greedy>(); },
      [] { return std::make_unique<Asap2020>(); },
      [] { return std::make_unique<Asap2022>(); },
      [] { return std::make_unique<Deadline>(); },
  };
  for (std::size_t s = 0; s < schemes.size(); ++s) {
    for (const double beta_ns : {300.0, 30'000.0}) {  // it keeps up; it does not
      SCOPED_TRACE(testing::Message() << "scheme " << s << ", beta " << beta_ns);
      const auto scheme = schemes[s]();
      std::uint64_t delivered = 0;
      Simulator simulator(*scheme, LinearCost({.alpha_us = 10, .beta_ns = beta_ns}), {},
                          [&](EventSpan events) { delivered += events.size(); });
      std::uint64_t fed = 0;
      for (std::int64_t begin_us = kUnix_us; begin_us < kUnix_us + 10 * kHour_us;) {
        for (const std::int64_t silence_us :
             {kMinute_us / 60, 36 * kMinute_us, 72 * kMinute_us, 180 * kMinute_us}) {
          Events events = burst;
          for (Event& event : events) event.t += begin_us;
          begin_us += 40'000 + silence_us;
          simulator.feed(events);
          fed += events.size();
        }
      }
      simulator.finish();
      const Ledger ledger = simulator.ledger();
      EXPECT_TRUE(ledger.balanced());
      EXPECT_EQ(ledger.received, fed);
      EXPECT_EQ(ledger.delivered, delivered);
      EXPECT_EQ(ledger.pending, 0u);
      if (beta_ns > 300) continue;
      std::vector<std::int64_t> in_time;  // events of each burst, by slot
      const std::span<const Slot> slots = simulator.slots();
      ASSERT_EQ(slots.size() % 40, 0u);
      for (std::size_t i = 0; i < slots.size(); ++i) {
        if (i % 40 == 0) in_time.push_back(0);
        ASSERT_EQ(slots[i].delivered, slots[i].received);
        if (slots[i].latency_max_ns <= 10'000'000) in_time.back() += slots[i].delivered;
      }
      in_time.erase(in_time.begin(), in_time.begin() + 2);  // in which a scheme learns
      in_time.pop_back();                                   // which the end of the source flushes
      EXPECT_GT(in_time.front(), 1000);
      EXPECT_EQ(in_time, std::vector(in_time.size(), in_time.front()));
    }
  }
}

// ---- losses and errors

struct Trouble {
  int code;
};

TEST(Simulator, AnExceptionOfTheConsumerComesOutUnchanged) {
  for (const std::size_t chunk : {1u, 10u, 1000u}) {
    FixedSize scheme({.size = 10});
    int calls = 0;
    Simulator simulator(scheme, slow(), {.capacity = 200}, [&](const Package&) {
      if (++calls == 4) throw Trouble{7};
    });
    const Events events = evenly_spaced(1000, 30);
    int code = 0;
    std::size_t fed = 0;
    try {
      for (; fed < events.size(); fed += chunk) {
        simulator.feed(EventSpan(events).subspan(fed, std::min(chunk, events.size() - fed)));
      }
    } catch (const Trouble& trouble) {
      code = trouble.code;
    }
    EXPECT_EQ(code, 7);
    EXPECT_EQ(calls, 4);
    EXPECT_EQ(simulator.log().size(), 3u);
    EXPECT_TRUE(simulator.stats().failed);
    const Ledger ledger = simulator.ledger();
    EXPECT_EQ(ledger.delivered, 30u);
    EXPECT_EQ(ledger.received, fed + chunk);
    EXPECT_EQ(ledger.pending, ledger.received - 30);
    EXPECT_TRUE(ledger.balanced());
  }
}

TEST(Simulator, ACostThatIsNoTimeIsRefusedByItsCall) {
  FixedSize scheme({.size = 10});
  Simulator simulator(scheme, [](std::size_t, double t_us) { return t_us < 1000 ? 1.0 : -1.0; });
  const Events events = evenly_spaced(100, 30);
  EXPECT_EQ(test::error_of([&] { simulator.feed(events); }),
            "cost(10, 1170) = -1: give the us that n events take, from t_us on: finite and not "
            "negative");
  EXPECT_TRUE(simulator.ledger().balanced());
}

TEST(Simulator, ACostThatIsNoneIsRefused) {
  FixedSize scheme;
  EXPECT_EQ(test::error_of([&] { Simulator(scheme, CostFunction()); }),
            "cost = none: give the us that n events take");
}

TEST(Simulator, ItsStatsAreThoseOfTheRun) {
  FixedSize scheme({.size = 10});
  Simulator simulator(scheme, slow());
  Events events = evenly_spaced(1000, 30);
  for (std::size_t i = 500; i < events.size(); ++i) events[i].t -= 2'000'000;  // a clock set back
  simulator.feed(events);
  const RunStats earlier = simulator.stats();
  simulator.finish();
  const RunStats stats = simulator.stats();
  EXPECT_EQ(stats.ledger, simulator.ledger());
  EXPECT_EQ(stats.packages.count, simulator.log().size());
  EXPECT_EQ(stats.packages.size, 1000u);
  EXPECT_EQ(stats.packages.size_max, 10u);
  EXPECT_EQ(stats.latency.count(), 1000u);
  EXPECT_EQ(stats.clock_resets, 1u);
  EXPECT_FALSE(stats.failed);
  EXPECT_EQ(stats.latency.since(earlier.latency).count(),
            (stats.ledger - earlier.ledger).delivered);
}

// Losses of every kind: rejected, filtered, discarded by gamma, stale, overflow.
TEST(Simulator, TheMaskLeadsBackToTheEventsThatWereGiven) {
  const FrontFilter every_fourth_is_noise = [](EventSpan events, std::span<Event> out) {
    std::size_t passed = 0;
    for (const Event& event : events) {
      if (number_of(event) % 4 != 0) out[passed++] = event;
    }
    return passed;
  };
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Events events = test::random_stream(seed, 20'000);
    Deadline deadline({.latency = 1ms});
    Asap2020 asap2020({.rate_bound = 1e5, .first_size = 20});
    Scheme& scheme = seed % 2 == 0 ? static_cast<Scheme&>(deadline) : asap2020;
    Events delivered;
    Simulator simulator(scheme, LinearCost({.alpha_us = 30, .beta_ns = 5000}),
                        {.latency = 1000us,
                         .capacity = seed % 3 == 0 ? 50u : 5000u,
                         .validator = {.width = 15'000},
                         .execution = seed % 4 < 2 ? Execution::anytime : Execution::whole,
                         .front_filter = seed % 5 < 2 ? every_fourth_is_noise : FrontFilter{},
                         .keep_mask = true},
                        [&](const Package& package) {
                          delivered.insert(delivered.end(), package.events.begin(),
                                           package.events.end());
                        });
    for (std::size_t at = 0; at < events.size(); at += 700) {
      simulator.feed(EventSpan(events).subspan(at, std::min<std::size_t>(700, events.size() - at)));
    }
    simulator.finish();

    const KeptEvents reading = simulator.kept().value();
    ASSERT_EQ(reading.kept.size(), events.size());
    Events kept;
    for (std::size_t i = 0; i < events.size(); ++i) {
      if (reading.kept[i] == 1) kept.push_back(events[i]);
    }
    EXPECT_EQ(kept, delivered);

    const RunLog& log = simulator.log();
    ASSERT_EQ(reading.first.size(), log.size());
    auto event = delivered.begin();  // of the kept ones, the first of this package
    std::int64_t after = 0;          // the last one of the package before
    for (std::size_t i = 0; i < log.size(); ++i) {
      const auto first_kept = static_cast<std::int64_t>(number_of(*event));
      ASSERT_GE(reading.first[i], after);
      ASSERT_LE(reading.first[i], first_kept);
      const bool is_last = i + 1 == log.size();
      const auto next = is_last ? static_cast<std::int64_t>(events.size()) : reading.first[i + 1];
      ASSERT_LE(reading.first[i] + log[i].offered, next);
      if (log[i].gamma == 1.0 && seed % 5 >= 2) {
        ASSERT_EQ(reading.first[i], first_kept);
      }
      event += log[i].size;
      after = static_cast<std::int64_t>(number_of(*(event - 1))) + 1;
    }
  }
}

TEST(Simulator, KeepsNoMaskUnlessAskedNorOfEventsThatTheFilterInFrontHasChanged) {
  Greedy scheme;
  EXPECT_FALSE(Simulator(scheme, slow()).kept());
  const auto moved = [](EventSpan events, std::span<Event> out) {
    std::copy(events.begin(), events.end(), out.begin());
    out[0].x += 1;
    return events.size();
  };
  Simulator simulator(scheme, slow(), {.front_filter = moved, .keep_mask = true});
  simulator.feed(kSmall);
  simulator.finish();
  EXPECT_FALSE(simulator.kept());
}

TEST(Simulator, WhatWaitsWhenARunEndsEarlyIsNotKept) {
  FixedSize scheme({.size = 10});
  int calls = 0;
  Simulator simulator(scheme, slow(), {.keep_mask = true}, [&](const Package&) {
    if (++calls == 3) throw Trouble{7};
  });
  const Events events = evenly_spaced(100, 30);
  EXPECT_THROW(simulator.feed(events), Trouble);
  const KeptEvents reading = simulator.kept().value();
  EXPECT_EQ(std::count(reading.kept.begin(), reading.kept.end(), 1), 20);
  EXPECT_EQ(reading.first, (std::vector<std::int64_t>{0, 10}));
}

TEST(Simulator, KnowsHowManyWereInTime) {
  Greedy scheme;
  Simulator simulator(scheme, slow(), {.latency = 150us});
  simulator.feed(kSmall);
  simulator.finish();
  // 0 takes 110 us; 50, 60, 70 are done at 240; 500 and 900 take 110.
  EXPECT_EQ(simulator.stats().latency.within_bound(), 3u);
  EXPECT_EQ(simulator.stats().latency.max_ns(), 190'000);
}

TEST(MakeSimulator, GivesAnObjectOrAMessage) {
  SingleEvent scheme;
  const Result<Simulator> simulator = make_simulator(scheme, {.alpha_us = 1, .beta_ns = 0});
  ASSERT_TRUE(simulator) << simulator.message();
  simulator->feed(test::evenly_spaced(10, 100));
  simulator->finish();
  EXPECT_EQ(simulator->ledger().delivered, 10u);
  EXPECT_EQ(make_simulator(scheme, {.noise = -1}).message(), "noise = -1: must be between 0 and 5");
}

TEST(MakeSimulator, WhereverMemoryEndsItHasTakenNothing) {
  Greedy scheme;
  const RunConfig small{.capacity = 64};
  EXPECT_GT(test::allocations_until_made([&] { return make_simulator(scheme, {}, small); }), 5);
}

}  // namespace
}  // namespace asap::simulator_test
