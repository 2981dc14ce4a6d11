#include "packager/packager.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "asap/filter/gamma_filter.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "asap/telemetry/ledger.hpp"
#include "core/random.hpp"
#include "packager/event_times.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"
#include "telemetry/telemetry.hpp"

namespace asap::packager_test {
namespace {

using namespace std::chrono_literals;

using test::at_times;
using test::evenly_spaced;
using test::Events;
using test::numbers_of;
using test::ScriptedScheme;

using Numbers = std::vector<std::uint64_t>;
using Step = Packager::Step;

constexpr std::int64_t kMicrosecond = 1000;
constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kBound_ns = 10'000'000;

// A ring and a packager, with the books of what went in.
struct Rig {
  explicit Rig(Scheme& scheme, std::size_t capacity = 1024, PackagerConfig config = {})
      : buffer(capacity), packager(buffer, ages, scheme, telemetry, config) {
    packager.begin(TimeAxis(0, 1.0), 0);
  }

  void push(EventSpan events) {
    received += events.size();
    const std::uint64_t first = buffer.tail();
    const std::size_t taken = buffer.push(events);
    ages.observe(events.first(taken), first, [](std::int64_t stamp) { return 1000 * stamp; });
  }

  Packager::Next next(std::int64_t now_ns) {
    telemetry.log.make_room();
    return packager.next(now_ns);
  }

  // The next package, finished after cost_ns.
  std::optional<Package> deliver(std::int64_t now_ns, std::int64_t cost_ns = 0) {
    const Packager::Next next = this->next(now_ns);
    if (next.step != Step::package) return std::nullopt;
    last.assign(next.package.events.begin(), next.package.events.end());
    packager.complete(next.package, now_ns + cost_ns);
    return next.package;
  }

  Ledger ledger() const {
    return {.received = received,
            .filtered = telemetry.filtered,
            .discarded = telemetry.discarded,
            .stale = telemetry.stale,
            .overflow = buffer.overflow(),
            .delivered = telemetry.delivered,
            .pending = buffer.size()};
  }

  EventBuffer buffer;
  AgeSlots ages{kBound_ns / 64};
  Telemetry telemetry{kBound_ns};
  Packager packager;
  std::uint64_t received = 0;
  Events last;  // events of the package delivered last
};

ScriptedScheme taking(std::size_t raw, double gamma = 1.0) {
  return ScriptedScheme([=](const Backlog&) { return Decision::take(raw, gamma); });
}

// What a package holds event by event, its row and what a scheme is told: tests/simulation.

// ---- where the events lie

TEST(Packager, AtGammaOneAPackageIsASliceOfTheRing) {
  ScriptedScheme scheme = taking(3);
  Rig rig(scheme, 8);
  rig.push(evenly_spaced(8, 1));
  const EventPieces ring = rig.buffer.peek();
  const Packager::Next next = rig.next(0);
  EXPECT_EQ(next.package.events.data(), ring.first.data());
  EXPECT_EQ(next.package.events.size(), 3u);
  EXPECT_EQ(rig.buffer.size(), 8u) << "the events stay in the ring until the package is completed";
  rig.packager.complete(next.package, 0);
  EXPECT_EQ(rig.buffer.size(), 5u);
}

TEST(Packager, AcrossTheWrapAPackageIsOnePiece) {
  ScriptedScheme scheme = taking(6);
  Rig rig(scheme, 8);
  const Events events = evenly_spaced(14, 1);
  rig.push(EventSpan(events).first(6));
  rig.deliver(0);
  rig.push(EventSpan(events).last(8));
  rig.deliver(0);
  EXPECT_EQ(numbers_of(rig.last), (Numbers{6, 7, 8, 9, 10, 11}));
}

TEST(Packager, SeesNoEventThatCameAfterTheLookAtTheRing) {
  Greedy scheme;
  Rig rig(scheme);
  rig.push(at_times({10, 20, 30}));
  const std::uint64_t seen = rig.buffer.tail();
  rig.push(at_times({40, 50}));
  rig.buffer.close();
  rig.telemetry.log.make_room();
  Packager::Next next = rig.packager.next(30 * kMicrosecond, seen);
  ASSERT_EQ(next.step, Step::package);
  EXPECT_EQ(next.package.t_last(), 30);
  rig.packager.complete(next.package, 35 * kMicrosecond);
  next = rig.packager.next(35 * kMicrosecond, seen);
  EXPECT_EQ(next.step, Step::wait) << "two have come meanwhile";
  EXPECT_EQ(next.until_tail, seen + 1);
  EXPECT_EQ(rig.deliver(60 * kMicrosecond)->raw, 2u);
  EXPECT_EQ(rig.next(70 * kMicrosecond).step, Step::ended);
}

void last_event_of_a_burst_arrives_within_the_bound(Scheme& scheme) {
  Rig rig(scheme);
  rig.push(at_times({100, 200, 300}));
  const Packager::Next wait = rig.next(300 * kMicrosecond);
  ASSERT_EQ(wait.step, Step::wait);
  EXPECT_LE(wait.until_ns, 100 * kMicrosecond + kBound_ns);
  EXPECT_GT(wait.until_tail, rig.buffer.tail());
  std::size_t delivered = 0;
  int asked = 0;
  for (std::int64_t now_ns = wait.until_ns; delivered < 3;) {
    ASSERT_LE(now_ns, 300 * kMicrosecond + kBound_ns);
    ASSERT_LE(++asked, 10) << "a wait that never ends";
    if (rig.deliver(now_ns)) {
      delivered += rig.last.size();
    } else {
      now_ns = rig.next(now_ns).until_ns;
    }
  }
}

TEST(Packager, ReferenceDefect4_APartialPackageIsNotKeptForEver) {
  FixedSize fixed_size({.size = 1000});
  last_event_of_a_burst_arrives_within_the_bound(fixed_size);
  Asap2020 asap2020;
  last_event_of_a_burst_arrives_within_the_bound(asap2020);
  FixedTime fixed_time({.period = 1000ms});
  last_event_of_a_burst_arrives_within_the_bound(fixed_time);
  ScriptedScheme lazy([](const Backlog&) { return Decision::wait_until(kNever); });
  last_event_of_a_burst_arrives_within_the_bound(lazy);
}

TEST(Packager, ReferenceDefect5_AbsurdTimesGiveNoNaN) {
  constexpr std::int64_t kYear_ns = 365LL * 86400 * 1'000'000'000;
  Asap2020 scheme({.first_size = 2});
  for (const std::int64_t cost_ns : {std::int64_t{0}, std::int64_t{-1}, -kYear_ns, kYear_ns}) {
    Rig rig(scheme);
    rig.push(at_times({5, 5, 5, 5, 5, 5, 5, 5, 5, 5}));
    std::size_t delivered = 0;
    for (std::int64_t now_ns = 0; delivered < 10; now_ns += kBound_ns) {
      if (rig.deliver(now_ns, cost_ns)) delivered += rig.last.size();
    }
    for (std::size_t i = 0; i < rig.telemetry.log.size(); ++i) {
      const PackageRow row = rig.telemetry.log[i];
      for (const double value : {row.start_us, row.processing_us, row.gamma, row.event_rate,
                                 row.rate, row.margin_us, row.latency_max_us}) {
        ASSERT_TRUE(std::isfinite(value));
      }
      ASSERT_DOUBLE_EQ(row.rate, static_cast<double>(row.size) * 1e6) << "span 0 counts as 1 us";
    }
    EXPECT_TRUE(std::isfinite(rig.telemetry.latency.mean_ns()));
  }
}

// ---- gamma

TEST(Packager, TakesThatKeepNothingCountToTheNextPackage) {
  // Single events at gamma 0.1: every package holds one event, of about ten that were offered.
  ScriptedScheme scheme = taking(1, 0.1);
  Rig rig(scheme, 4096);
  double estimate = 0;
  std::size_t offered = 0;
  for (std::int64_t t_us = 0; t_us < 1'000'000; t_us += 100) {
    rig.push(at_times({t_us}));
    if (const auto package = rig.deliver(t_us * kMicrosecond)) {
      EXPECT_EQ(package->gamma, 1.0 / static_cast<double>(package->offered));
      estimate += 1 / package->gamma;
      offered += package->offered;
    }
  }
  EXPECT_NEAR(estimate, static_cast<double>(offered), 1e-6);
  EXPECT_NEAR(estimate, 10'000, 100) << "the last ones have no package yet";
}

// The parts stand for all events that thinning has seen, too: whole and anytime packages in any
// order, with and without a filter in front. The last event is taken whole and passes that filter:
// what was thinned behind the last part is told with it.
TEST(Packager, LosesNothingAndDoublesNothing) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(seed);
    std::uint64_t draws = 0;
    const auto draw = [&](std::uint64_t limit) { return random(draws++) % limit; };
    bool takes_all = false;
    ScriptedScheme scheme([&](const Backlog& backlog) {
      if (takes_all) return Decision::take(backlog.count);
      const double keeps[] = {1, 0.3, 0};
      const double costs[] = {0, 100, 10'000};
      // One by one: as arguments, each compiler would draw them in an order of its own.
      const double keep = keeps[draw(3)], cost = costs[draw(3)];
      const std::size_t raw = 1 + draw(2 * backlog.count);
      const auto budget_ns = static_cast<std::int64_t>(draw(3)) * kMillisecond / 2;
      Decision decision = Decision::take(raw, keep);
      decision.budget_ns = draw(4) == 0 ? kNever : budget_ns;
      decision.event_ns = cost;
      return decision;
    });
    const std::size_t capacity = 500 + 300 * draw(8);
    const std::size_t max_copied = seed % 2 == 0 ? capacity : 1 + draw(capacity);
    FrontFilter front_filter;
    if (seed % 3 == 0) {
      front_filter = [](EventSpan events, std::span<Event> out) {
        const auto is_even = [](const Event& event) { return event.t % 2 == 0; };
        return static_cast<std::size_t>(
            std::copy_if(events.begin(), events.end(), out.begin(), is_even) - out.begin());
      };
    }
    Rig rig(scheme, capacity,
            {.seed = seed, .front_filter = front_filter, .max_copied = max_copied});
    const Events events = evenly_spaced(30'001, 1);
    std::size_t at = 0;
    std::int64_t now_ns = 0;
    std::int64_t last = -1;
    double estimate = 0;
    while (!takes_all || rig.buffer.size() > 0) {
      const std::size_t free = capacity - rig.buffer.size();
      takes_all = at + 1 == events.size() && rig.buffer.size() == 0;
      const std::size_t more =
          takes_all ? 1 : std::min<std::size_t>({draw(900), free, events.size() - 1 - at});
      rig.push(EventSpan(events).subspan(at, more));
      at += more;
      const Packager::Next next = rig.packager.next(now_ns);
      if (next.step != Step::package) {
        now_ns = std::min(next.until_ns, now_ns + kMillisecond);
        continue;
      }
      Package package = next.package;
      rig.telemetry.log.make_room();
      const std::uint64_t head = rig.buffer.head();
      Numbers parts;
      for (;;) {
        const EventSpan part = rig.packager.stratum(package, now_ns);
        if (part.empty()) break;
        estimate += static_cast<double>(part.size()) / package.gamma;
        for (const std::uint64_t number : numbers_of(part)) parts.push_back(number);
        now_ns += static_cast<std::int64_t>(draw(draw(10) == 0 ? 5'000'000 : 50'000));
      }
      ASSERT_EQ(numbers_of(package.events), parts);
      for (const std::uint64_t number : parts) {
        ASSERT_GT(static_cast<std::int64_t>(number), last);
        last = static_cast<std::int64_t>(number);
      }
      rig.packager.complete(package, now_ns);
      ASSERT_EQ(rig.buffer.head(), head + package.raw);
      ASSERT_GE(package.raw, 1u);
      ASSERT_LT(last, static_cast<std::int64_t>(rig.buffer.head()));
      ASSERT_TRUE(rig.ledger().balanced());
    }
    std::uint64_t offered = 0;
    for (std::size_t i = 0; i < rig.telemetry.log.size(); ++i) {
      offered += static_cast<std::uint64_t>(rig.telemetry.log[i].offered);
    }
    EXPECT_LE(offered, 30'001u);
    const Ledger ledger = rig.ledger();
    EXPECT_EQ(ledger.delivered + ledger.discarded + ledger.filtered, 30'001u);
    EXPECT_NEAR(estimate, static_cast<double>(ledger.delivered + ledger.discarded), 1e-6);
  }
}

}  // namespace
}  // namespace asap::packager_test
