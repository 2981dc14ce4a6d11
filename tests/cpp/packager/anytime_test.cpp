// Anytime packages through the packager: strata, where their events lie, what leaves the ring.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "asap/filter/gamma_filter.hpp"
#include "core/random.hpp"
#include "packager/rig.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::anytime_test {
namespace {

using test::evenly_spaced;
using test::Events;
using test::numbers_of;
using test::ScriptedScheme;

using Numbers = std::vector<std::uint64_t>;
using Step = Packager::Step;

constexpr std::int64_t kMicrosecond = 1000;
constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kBound_ns = 10 * kMillisecond;

Decision within(std::int64_t budget_ns, std::size_t raw, double event_ns = 0.0,
                double gamma = 1.0) {
  Decision decision = Decision::take(raw, gamma);
  decision.budget_ns = budget_ns;
  decision.event_ns = event_ns;
  return decision;
}

ScriptedScheme always(Decision decision) {
  return ScriptedScheme([=](const Backlog&) { return decision; });
}

Numbers numbers_between(std::uint64_t begin, std::uint64_t end) {
  Numbers numbers;
  for (std::uint64_t i = begin; i < end; ++i) numbers.push_back(i);
  return numbers;
}

struct Rig : test::PackagerRig {
  explicit Rig(Scheme& scheme, std::size_t capacity = 4096, PackagerConfig config = {})
      : PackagerRig(scheme, capacity, config) {}

  // Opens a package; a test that expects one fails without.
  Package open(std::int64_t now_ns = 0) {
    const Packager::Next next = this->next(now_ns);
    EXPECT_EQ(next.step, Step::package);
    return next.package;
  }

  // Runs a package to its end, an event in event_ns; the parts, each as it was handed out.
  std::vector<Numbers> run(Package& package, double event_ns, std::int64_t now_ns = 0) {
    std::vector<Numbers> parts;
    for (;;) {
      const EventSpan part = packager.stratum(package, now_ns);
      if (part.empty()) break;
      EXPECT_EQ(part.data() + part.size(), package.events.data() + package.events.size());
      parts.push_back(numbers_of(part));
      now_ns += std::llround(event_ns * static_cast<double>(part.size()));
    }
    packager.complete(package, now_ns);
    return parts;
  }
};

TEST(Anytime, NextOpensAPackageAndStrataShowItsEvents) {
  ScriptedScheme scheme = always(within(kMillisecond, 640));
  Rig rig(scheme);
  rig.push(evenly_spaced(1000, 1));
  Package package = rig.open(7);
  EXPECT_EQ(scheme.execution, Execution::anytime);
  EXPECT_TRUE(package.events.empty());
  EXPECT_EQ(package.raw, 0u);
  EXPECT_EQ(package.gamma, 1.0);
  EXPECT_EQ(package.start_ns, 7);
  EXPECT_EQ(rig.packager.stratum(package, 7).size(), 64u);
  EXPECT_EQ(package.events.size(), 64u);
  EXPECT_EQ(package.raw, 64u);
  EXPECT_EQ(package.offered, 64u);
  EXPECT_EQ(rig.packager.stratum(package, 100).size(), 64u);
  EXPECT_EQ(package.events.size(), 128u);
  const std::vector<Numbers> rest = rig.run(package, 1.0, 200);
  ASSERT_EQ(rest.size(), 8u);
  EXPECT_EQ(rest.back(), numbers_between(576, 640));
  EXPECT_EQ(numbers_of(package.events), numbers_between(0, 640));
  EXPECT_EQ(rig.buffer.size(), 360u);
  EXPECT_EQ(rig.telemetry.log[0].size, 640);
  EXPECT_EQ(rig.telemetry.log[0].processing_us, (200 - 7 + 8 * 64) * 1e-3);
  ASSERT_EQ(scheme.outcomes.size(), 1u);
  EXPECT_EQ(scheme.outcomes[0].raw, 640u);
  EXPECT_EQ(scheme.outcomes[0].size, 640u);
  EXPECT_EQ(scheme.outcomes[0].span_ns, 639 * kMicrosecond);
  EXPECT_TRUE(rig.ledger().balanced());
}

TEST(Anytime, AWholePackageComesAtOnce) {
  const auto comes_at_once = [](Decision decision, Execution execution) {
    ScriptedScheme scheme = always(decision);
    Rig rig(scheme, 4096, {.execution = execution});
    rig.push(evenly_spaced(1000, 1));
    Package package = rig.open();
    EXPECT_EQ(scheme.execution, execution);
    EXPECT_EQ(package.events.size(), 640u);
    EXPECT_EQ(package.raw, 640u);
    const std::vector<Numbers> parts = rig.run(package, 1000.0);
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0], numbers_between(0, 640));
  };
  comes_at_once(Decision::take(640), Execution::anytime);
  comes_at_once(within(1, 640, 1000.0), Execution::whole);
}

// ---- where the events lie

TEST(Anytime, AThinnedStratumMovesThePackageOutOfTheRing) {
  ScriptedScheme scheme = always(within(100 * kMicrosecond, 640, 1.0));
  Rig rig(scheme, 1024, {.seed = 9});
  rig.push(evenly_spaced(1000, 1));
  const Event* const ring = rig.buffer.peek().first.data();
  Package package = rig.open();
  const EventSpan first = rig.packager.stratum(package, 0);
  EXPECT_EQ(first.data(), ring);
  const EventSpan second = rig.packager.stratum(package, 90 * kMicrosecond);
  EXPECT_LT(second.size(), 64u);
  EXPECT_GT(second.size(), 0u);
  EXPECT_NE(package.events.data(), ring);
  EXPECT_EQ(second.data(), package.events.data() + 64);
  EXPECT_EQ(numbers_of(package.events.first(64)), numbers_between(0, 64));
  EXPECT_EQ(numbers_of(first), numbers_between(0, 64)) << "what was handed out stays valid";
}

TEST(Anytime, EventsLeftInTheRingMeetTheSameHash) {
  // Whatever was executed, event number i is decided by random(i).
  int asked = 0;
  ScriptedScheme scheme([&](const Backlog& backlog) {
    return asked++ == 0 ? within(1, 640, 1e9) : Decision::take(backlog.count, 0.5);
  });
  Rig rig(scheme, 1024, {.seed = 4});
  rig.push(evenly_spaced(1000, 1));
  Package early = rig.open();
  (void)rig.packager.stratum(early, 0);
  while (!rig.packager.stratum(early, kBound_ns).empty()) continue;
  rig.packager.complete(early, kBound_ns);
  const std::uint64_t head = rig.buffer.head();
  EXPECT_LT(head, 640u);
  Package rest = rig.open(kBound_ns);
  const CounterRandom random(4);
  Numbers expected;
  for (std::uint64_t i = head; i < 1000; ++i) {
    if (random(i) >> 63 == 0) expected.push_back(i);
  }
  EXPECT_EQ(numbers_of(rest.events), expected);
}

// ---- whatever happens

// The parts stand for all events that thinning has seen, too: whole and anytime packages in any
// order, with and without a filter in front. The last event is taken whole and passes that filter:
// what was thinned behind the last part is told with it.
TEST(Anytime, LosesNothingAndDoublesNothing) {
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
      Decision decision = within(budget_ns, raw, cost, keep);
      if (draw(4) == 0) decision.budget_ns = kNever;
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
}  // namespace asap::anytime_test
