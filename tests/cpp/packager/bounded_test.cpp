// Packages that are copied, of at most so many events: what is more follows as the next one.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "packager/event_times.hpp"
#include "packager/packager.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::bounded_test {
namespace {

using test::evenly_spaced;
using test::numbers_of;
using test::ScriptedScheme;

constexpr std::size_t kMax = 100;
constexpr std::size_t kUnbounded = std::numeric_limits<std::size_t>::max();

Decision within_a_ms(std::size_t raw, double gamma, double event_ns) {
  Decision decision = Decision::take(raw, gamma);
  decision.budget_ns = 1'000'000;
  decision.event_ns = event_ns;
  return decision;
}

// A ring of 1024 that begins at `first` and holds 1000 events, and what comes out of it.
struct Rig {
  explicit Rig(Decision decision, std::size_t max_copied = kMax, std::uint64_t first = 0)
      : scheme([decision](const Backlog&) { return decision; }),
        buffer(1024, first),
        packager(buffer, ages, scheme, telemetry, {.max_copied = max_copied}) {
    packager.begin(TimeAxis(0, 1.0), 0);
    buffer.push(evenly_spaced(1000, 1));
    buffer.close();
  }

  // The algorithm needs event_ns per event.
  void run(std::int64_t event_ns = 0) {
    std::int64_t now_ns = 0;
    for (;;) {
      telemetry.log.make_room();
      const Packager::Next next = packager.next(now_ns);
      if (next.step == Packager::Step::ended) break;
      Package package = next.package;
      for (EventSpan part = packager.stratum(package, now_ns); !part.empty();
           part = packager.stratum(package, now_ns)) {
        for (const std::uint64_t number : numbers_of(part)) delivered.push_back(number);
        now_ns += event_ns * static_cast<std::int64_t>(part.size());
      }
      sizes.push_back(package.events.size());
      offered += package.offered;
      packager.complete(package, now_ns);
    }
  }

  std::uint64_t booked() const { return telemetry.delivered + telemetry.discarded; }

  ScriptedScheme scheme;
  EventBuffer buffer;
  AgeSlots ages{1000};
  Telemetry telemetry{10'000'000};
  Packager packager;
  std::vector<std::uint64_t> delivered;
  std::vector<std::size_t> sizes;
  std::uint64_t offered = 0;
};

TEST(Bounded, TheRestOfAThinnedPackageFollows) {
  Rig unbounded(Decision::take(1000, 0.5), kUnbounded);
  Rig rig(Decision::take(1000, 0.5));
  unbounded.run();
  rig.run();
  EXPECT_EQ(unbounded.sizes.size(), 1u);
  EXPECT_EQ(rig.delivered, unbounded.delivered);
  EXPECT_EQ(rig.sizes.size(), (rig.delivered.size() + kMax - 1) / kMax);
  for (std::size_t i = 0; i + 1 < rig.sizes.size(); ++i) EXPECT_EQ(rig.sizes[i], kMax);
  EXPECT_EQ(rig.booked(), 1000u);
  EXPECT_EQ(rig.offered, 1000u);
  ASSERT_EQ(rig.scheme.outcomes.size(), rig.sizes.size());
  EXPECT_LT(rig.scheme.outcomes[0].raw, 300u) << "the scheme is told what was taken";
}

TEST(Bounded, AllThatIsKeptIsDeliveredAcrossTheEndOfTheRing) {
  Rig rig(Decision::take(1000), kMax, 1024 - 600);
  rig.run();
  EXPECT_EQ(rig.sizes, (std::vector<std::size_t>{600, 400})) << "two slices";
  EXPECT_EQ(rig.delivered.size(), 1000u);
  EXPECT_EQ(rig.booked(), 1000u);
}

TEST(Bounded, AFullAnytimePackageEndsAndTheNextBegins) {
  for (const std::uint64_t first : {0U, 1024U - 600U}) {
    // 0.1 ms for what fits in, and more events than that: thinned from the second stratum on
    Rig rig(within_a_ms(1000, 1.0, 1.0), kMax, first);
    rig.run(5'000);
    ASSERT_GT(rig.sizes.size(), 2u);
    std::uint64_t last = 0;
    for (const std::uint64_t number : rig.delivered) {
      ASSERT_GE(number, last);
      last = number + 1;
    }
    EXPECT_EQ(rig.delivered.size(), rig.telemetry.delivered);
    EXPECT_EQ(rig.booked(), 1000u);
    EXPECT_EQ(rig.offered, 1000u);
  }
}

TEST(Bounded, AsManyAsFitAreNotCut) {
  Rig rig(Decision::take(100), kMax, 1024 - 50);
  rig.run();
  EXPECT_EQ(rig.sizes, std::vector<std::size_t>(10, 100));
}

TEST(Bounded, RefusesAPackageOfNothing) {
  EXPECT_THROW(Rig(Decision::take(1), 0), std::invalid_argument);
}

}  // namespace
}  // namespace asap::bounded_test
