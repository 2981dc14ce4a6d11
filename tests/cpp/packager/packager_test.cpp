#include "packager/packager.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "asap/filter/gamma_filter.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "packager/rig.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::packager_test {
namespace {

using namespace std::chrono_literals;

using test::at_times;
using test::evenly_spaced;
using test::Events;
using test::number_of;
using test::numbers_of;
using test::ScriptedScheme;

using Numbers = std::vector<std::uint64_t>;
using Step = Packager::Step;

constexpr std::int64_t kMicrosecond = 1000;
constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kBound_ns = test::PackagerRig::kBound_ns;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kHuge = std::numeric_limits<std::size_t>::max();

struct Rig : test::PackagerRig {
  explicit Rig(Scheme& scheme, std::size_t capacity = 1024, std::uint64_t seed = 0,
               std::size_t max_copied = kHuge)
      : PackagerRig(scheme, capacity, {.seed = seed, .max_copied = max_copied}) {}

  // The next package, finished after cost_ns.
  std::optional<Package> deliver(std::int64_t now_ns, std::int64_t cost_ns = 0) {
    const Packager::Next next = this->next(now_ns);
    if (next.step != Step::package) return std::nullopt;
    last.assign(next.package.events.begin(), next.package.events.end());
    packager.complete(next.package, now_ns + cost_ns);
    return next.package;
  }

  Events last;  // events of the package delivered last
};

ScriptedScheme taking(std::size_t raw, double gamma = 1.0) {
  return ScriptedScheme([=](const Backlog&) { return Decision::take(raw, gamma); });
}

// ---- what a package and its row say

TEST(Packager, ResetsTheSchemeBeforeTheRun) {
  ScriptedScheme scheme = taking(1);
  Rig rig(scheme);
  EXPECT_EQ(scheme.resets, 1);
}

TEST(Packager, TellsTheSchemeWhatWaits) {
  std::vector<Backlog> told;
  std::vector<std::size_t> counts;
  ScriptedScheme scheme([&](const Backlog& backlog) {
    told.push_back(backlog);
    for (const std::int64_t t_us : {0, 100, 101, 200, 250, 301}) {
      counts.push_back(backlog.counts.before(t_us * kMicrosecond));
    }
    return Decision::take(2);
  });
  Rig rig(scheme, 4);
  rig.push(at_times({90, 95}));
  rig.deliver(1 * kMillisecond, 100);  // so that what follows wraps
  rig.push(at_times({100, 200, 300}));
  rig.deliver(2 * kMillisecond);
  EXPECT_EQ(told[0].previous_start_ns, kLongAgo);
  EXPECT_EQ(told[1].count, 3u);
  EXPECT_EQ(told[1].now_ns, 2 * kMillisecond);
  EXPECT_EQ(told[1].oldest_ns, 100 * kMicrosecond);
  EXPECT_EQ(told[1].age_ns(), 1900 * kMicrosecond);
  EXPECT_EQ(told[1].previous_start_ns, 1 * kMillisecond);
  EXPECT_FALSE(told[1].due);
  counts.erase(counts.begin(), counts.begin() + 6);
  EXPECT_EQ(counts, (std::vector<std::size_t>{0, 0, 1, 1, 2, 3}));
}

TEST(Packager, HandsOutAPackageWithItsStory) {
  ScriptedScheme scheme = taking(2);
  Rig rig(scheme, 4);
  rig.push(at_times({10, 20, 30, 40, 50, 60, 70}));
  const auto first = rig.deliver(100 * kMicrosecond, 5 * kMicrosecond);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->index, 0u);
  EXPECT_EQ(first->gamma, 1.0);
  EXPECT_EQ(first->raw, 2u);
  EXPECT_EQ(first->offered, 2u);
  EXPECT_EQ(first->stale_before, 0u);
  EXPECT_EQ(first->overflow_before, 3u);
  EXPECT_EQ(first->start_ns, 100 * kMicrosecond);
  const auto second = rig.deliver(200 * kMicrosecond);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->index, 1u);
  EXPECT_EQ(second->overflow_before, 0u);
  rig.push(at_times({80, 90, 91, 92, 93}));
  EXPECT_EQ(rig.deliver(300 * kMicrosecond)->overflow_before, 1u);
}

TEST(Packager, FeedsBackWhatAPackageReallyWas) {
  ScriptedScheme scheme = taking(3);
  Rig rig(scheme);
  rig.push(at_times({100, 150, 300}));
  rig.deliver(1000, 777);
  ASSERT_EQ(scheme.outcomes.size(), 1u);
  EXPECT_EQ(scheme.outcomes[0].size, 3u);
  EXPECT_EQ(scheme.outcomes[0].raw, 3u);
  EXPECT_EQ(scheme.outcomes[0].span_ns, 200 * kMicrosecond);
  EXPECT_EQ(scheme.outcomes[0].start_ns, 1000);
  EXPECT_EQ(scheme.outcomes[0].processing_ns, 777);
}

TEST(Packager, DividesStampsBySpeed) {
  ScriptedScheme scheme = taking(2);
  Rig rig(scheme);
  rig.packager.begin(TimeAxis(5'000'000, 2.0), 0);
  rig.push(at_times({5'000'100, 5'000'300}));
  rig.deliver(1000 * kMicrosecond, 10 * kMicrosecond);
  const PackageRow row = rig.telemetry.log[0];
  EXPECT_EQ(row.start_us, 5'002'000.0);
  EXPECT_EQ(row.t_first, 5'000'100);
  EXPECT_DOUBLE_EQ(row.rate, 2e4);  // two in 100 us of wall time
  EXPECT_EQ(row.margin_us, -90.0);
  EXPECT_EQ(row.latency_max_us, 960.0);
}

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

// ---- takes that keep nothing, stale events

// ---- flush: nothing waits for a count that does not come

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

TEST(Packager, EndsWhenTheSourceHasEndedAndNothingWaits) {
  FixedSize scheme({.size = 100});
  Rig rig(scheme);
  rig.push(evenly_spaced(3, 1));
  EXPECT_EQ(rig.next(0).step, Step::wait);
  rig.buffer.close();
  ASSERT_TRUE(rig.deliver(0));
  EXPECT_EQ(rig.last.size(), 3u);
  EXPECT_EQ(rig.next(0).step, Step::ended);
  EXPECT_EQ(rig.next(0).step, Step::ended);
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

TEST(Packager, FlushesAtTheBoundAndNotBefore) {
  FixedSize scheme({.size = 1000});
  Rig rig(scheme);
  rig.push(at_times({100, 9000}));
  const std::int64_t due_ns = 100 * kMicrosecond + kBound_ns;
  const Packager::Next wait = rig.next(due_ns - 1);
  EXPECT_EQ(wait.step, Step::wait);
  EXPECT_EQ(wait.until_ns, due_ns);
  EXPECT_EQ(wait.until_tail, 1000u);
  ASSERT_TRUE(rig.deliver(due_ns));
  EXPECT_EQ(rig.last.size(), 2u);
}

TEST(Packager, FlushesAFullRing) {
  for (const std::size_t capacity : {1u, 2u, 8u}) {
    FixedSize scheme({.size = 1000});
    Rig rig(scheme, capacity);
    const Events events = evenly_spaced(capacity, 1);
    rig.push(EventSpan(events).first(capacity - 1));
    const Packager::Next wait = rig.next(0);
    EXPECT_EQ(wait.step, Step::wait);
    EXPECT_EQ(wait.until_tail, capacity) << "it wakes when the ring is full";
    rig.push(EventSpan(events).last(1));
    ASSERT_TRUE(rig.deliver(0));
    EXPECT_EQ(rig.last.size(), capacity);
  }
}

// ---- a scheme that answers nonsense does no harm

TEST(Packager, TakesAtLeastOneAndAtMostWhatWaits) {
  for (const std::size_t raw : {std::size_t{0}, std::size_t{1}, std::size_t{99}, kHuge}) {
    ScriptedScheme scheme = taking(raw);
    Rig rig(scheme);
    rig.push(evenly_spaced(5, 1));
    ASSERT_TRUE(rig.deliver(0));
    EXPECT_EQ(rig.last.size(), raw <= 1 ? 1u : 5u);
    EXPECT_TRUE(rig.ledger().balanced());
  }
}

TEST(Packager, KeepsAllForAGammaThatIsNone) {
  for (const double gamma : {kNaN, 2.0, std::numeric_limits<double>::infinity()}) {
    ScriptedScheme scheme = taking(5, gamma);
    Rig rig(scheme);
    rig.push(evenly_spaced(5, 1));
    const auto package = rig.deliver(0);
    ASSERT_TRUE(package);
    EXPECT_EQ(rig.last.size(), 5u);
    EXPECT_EQ(package->gamma, 1.0);
  }
  for (const double gamma : {-1.0, -std::numeric_limits<double>::infinity()}) {
    ScriptedScheme scheme = taking(5, gamma);
    Rig rig(scheme);
    rig.push(evenly_spaced(5, 1));
    EXPECT_FALSE(rig.deliver(0));
    EXPECT_EQ(rig.ledger().discarded, 5u);
  }
}

TEST(Packager, AWaitThatIsOverLetsTimePass) {
  for (const std::int64_t until_ns :
       {kLongAgo, std::int64_t{-1}, std::int64_t{0}, std::int64_t{7}}) {
    ScriptedScheme scheme([=](const Backlog&) { return Decision::wait_until(until_ns); });
    Rig rig(scheme);
    rig.push(at_times({0}));
    const Packager::Next next = rig.next(7);
    EXPECT_EQ(next.step, Step::wait);
    EXPECT_EQ(next.until_ns, 8);
  }
  for (const std::size_t count : {0u, 1u, 3u}) {
    ScriptedScheme scheme([=](const Backlog&) { return Decision::wait_for(count); });
    Rig rig(scheme);
    rig.push(evenly_spaced(3, 1));
    EXPECT_EQ(rig.next(7).until_tail, 4u);
  }
  ScriptedScheme scheme([](const Backlog&) { return Decision::wait_for(kHuge); });
  Rig rig(scheme, 8);
  rig.push(evenly_spaced(3, 1));
  EXPECT_EQ(rig.next(7).until_tail, 8u);
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

// ---- the promises, over random streams, schemes and decisions

void keeps_its_promises(Scheme& scheme, std::uint64_t seed, std::size_t capacity, bool loses) {
  const CounterRandom random(seed);
  const Events events = test::random_stream(seed, 5000);
  Rig rig(scheme, capacity, seed, seed % 2 == 0 ? kHuge : 1 + capacity / 4);
  std::int64_t now_ns = 0;
  std::int64_t last = -1;  // number of the newest event delivered
  std::size_t at = 0;
  for (std::uint64_t round = 0;; ++round) {
    ASSERT_LT(round, 200'000u) << "it does not come to an end";
    std::size_t arrived = at;
    while (arrived < events.size() && 1000 * events[arrived].t <= now_ns) ++arrived;
    rig.push(EventSpan(events).subspan(at, arrived - at));
    at = arrived;
    if (at == events.size()) rig.buffer.close();

    const Packager::Next next = rig.next(now_ns);
    ASSERT_TRUE(rig.ledger().balanced());
    ASSERT_LE(rig.ledger().pending, capacity);
    if (next.step == Step::ended) break;
    if (next.step == Step::wait) {
      ASSERT_GT(next.until_ns, now_ns);
      if (rig.buffer.size() > 0) {
        ASSERT_LE(next.until_ns, 1000 * rig.buffer.peek()[0].t + kBound_ns);
      }
      ASSERT_GT(next.until_tail, rig.buffer.tail());
      ASSERT_LE(next.until_tail, rig.buffer.head() + capacity);
      const std::int64_t arrival_ns = at < events.size() ? 1000 * events[at].t : now_ns;
      now_ns = std::min(next.until_ns, std::max(arrival_ns, now_ns + 1));
      continue;
    }
    const Package package = next.package;
    ASSERT_FALSE(package.events.empty());
    ASSERT_LE(package.events.size(), package.raw);
    for (const Event& event : package.events) {
      const auto number = static_cast<std::int64_t>(number_of(event));
      ASSERT_EQ(event, events[static_cast<std::size_t>(number)]);
      ASSERT_GT(number, last);
      if (!loses && rig.buffer.overflow() == 0) {
        ASSERT_EQ(number, last + 1);
      }
      last = number;
    }
    now_ns += static_cast<std::int64_t>(random(round) % 3'000'000);
    rig.packager.complete(package, now_ns);
    ASSERT_TRUE(rig.ledger().balanced());
  }
  const Ledger ledger = rig.ledger();
  EXPECT_EQ(ledger.received, events.size());
  EXPECT_EQ(ledger.pending, 0u);
  if (!loses) {
    EXPECT_EQ(ledger.delivered + ledger.overflow, ledger.received);
  }
  std::int64_t offered = 0;
  std::int64_t delivered = 0;
  for (std::size_t i = 0; i < rig.telemetry.log.size(); ++i) {
    offered += rig.telemetry.log[i].offered;
    delivered += rig.telemetry.log[i].size;
  }
  EXPECT_EQ(static_cast<std::uint64_t>(delivered), ledger.delivered);
  EXPECT_LE(static_cast<std::uint64_t>(offered), ledger.delivered + ledger.discarded);
  EXPECT_EQ(rig.telemetry.latency.count(), ledger.delivered);
}

TEST(Packager, KeepsItsPromisesUnderEveryScheme) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    for (const std::size_t capacity : {1u, 2u, 7u, 100u, 10'000u}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", capacity " << capacity);
      FixedSize fixed_size({.size = 37});
      keeps_its_promises(fixed_size, seed, capacity, false);
      FixedTime fixed_time({.period = 700us});
      keeps_its_promises(fixed_time, seed, capacity, false);
      SingleEvent single_event;
      keeps_its_promises(single_event, seed, capacity, false);
      Greedy greedy;
      keeps_its_promises(greedy, seed, capacity, false);
      Asap2020 asap2020({.rate_bound = 1e5, .first_size = 20});
      keeps_its_promises(asap2020, seed, capacity, true);
    }
  }
}

TEST(Packager, KeepsItsPromisesUnderNonsense) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(~seed);
    std::uint64_t asked = 0;
    ScriptedScheme scheme([&](const Backlog& backlog) {
      const std::uint64_t bits = random(asked++);
      const auto some = [&](int shift) {
        const std::size_t choices[] = {0, 1, 5, backlog.count, backlog.count + 1, kHuge};
        return choices[(bits >> shift) % 6];
      };
      const double keeps[] = {0, 1, 0.5, kNaN, -1, 2};
      const std::int64_t times[] = {kLongAgo, 0, backlog.now_ns, backlog.now_ns + 100, kNever};
      return Decision{.takes = bits % 3 != 0,
                      .until_ns = times[(bits >> 8) % 5],
                      .until_count = some(16),
                      .stale = bits % 7 == 0 ? some(24) : 0,
                      .raw = some(32),
                      .gamma = keeps[(bits >> 40) % 6]};
    });
    keeps_its_promises(scheme, seed, 1 + seed * seed, true);
  }
}

}  // namespace
}  // namespace asap::packager_test
