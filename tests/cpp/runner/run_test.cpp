#include "runner/run.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "asap/schemes/greedy.hpp"
#include "support/errors.hpp"
#include "support/scripted_scheme.hpp"
#include "support/streams.hpp"

namespace asap::run_test {
namespace {

using namespace std::chrono_literals;

using test::evenly_spaced;
using test::Events;

constexpr std::int64_t kMicrosecond = 1000;

TEST(Run, EventsOfARecordingArriveInOrderAndTheRestIsOverflow) {
  Greedy scheme;
  asap::Run run(scheme, {.capacity = 4}, asap::Run::Source::recording);
  run.begin(0);
  run.arrive(evenly_spaced(6, 10));
  EXPECT_EQ(test::numbers_of(run.buffer().peek().first), (std::vector<std::uint64_t>{0, 1, 2, 3}));
  EXPECT_EQ(run.buffer().overflow(), 2u);
}

TEST(Run, TheSchemeLearnsTheAgesOfWhatIsInTheRingOnTheAxis) {
  std::vector<std::size_t> older;
  test::ScriptedScheme scheme([&](const Backlog& backlog) {
    for (const std::int64_t us : {200, 400}) {
      older.push_back(backlog.counts.about_before(us * kMicrosecond));
    }
    return Decision::wait_for(1000);
  });
  asap::Run run(scheme, {.latency = 6400us, .capacity = 8},
                asap::Run::Source::recording);  // slots of 100 us
  run.begin(0, 2.0);
  run.arrive(evenly_spaced(8, 100));       // two in each slot
  run.arrive(evenly_spaced(2, 100, 800));  // overflow: not in the ring
  (void)run.packager().next(400 * kMicrosecond);
  EXPECT_EQ(older, (std::vector<std::size_t>{4, 8}));
}

TEST(Run, TheMaskKnowsWhatWasRejectedAndWhatFoundNoRoom) {
  Greedy scheme;
  asap::Run run(scheme, {.capacity = 2, .execution = Execution::whole, .keep_mask = true},
                asap::Run::Source::recording);
  run.begin(0);
  Events events = evenly_spaced(4, 10);
  events[1].t = -5;
  run.validator().check(events, [&](EventSpan good) { run.arrive(good); });
  run.buffer().close();
  Packager::Next next = run.packager().next(0);
  (void)run.packager().stratum(next.package, 0);
  run.packager().complete(next.package, 0);
  EXPECT_EQ(run.kept()->kept, (std::vector<std::uint8_t>{1, 0, 1, 0}));
  EXPECT_EQ(run.kept()->first, std::vector<std::int64_t>{0});
}

TEST(Run, TheLedgerIsBalancedFromOutsideAndFromInside) {
  Greedy scheme;
  for (const auto source : {asap::Run::Source::recording, asap::Run::Source::camera}) {
    asap::Run run(scheme, {.capacity = 8}, source);
    run.begin(0);
    Events events = evenly_spaced(5, 10);
    events[3].t = -5;
    run.validator().check(events, [&](EventSpan good) { run.buffer().push(good); });
    EXPECT_EQ(run.ledger(false).rejected, 0u);  // not published yet
    EXPECT_TRUE(run.ledger(false).balanced());
    run.publish();
    const Ledger expected{.received = 5, .rejected = 1, .pending = 4};
    EXPECT_EQ(run.ledger(false), expected);
    EXPECT_EQ(run.ledger(true), expected);
    EXPECT_EQ(run.rejected(), run.validator().rejected());
    // Three more were thinned out in front of the ring, two are on their way.
    const Ledger more = run.ledger(false, 3, 2);
    EXPECT_EQ(more.discarded, 3u);
    EXPECT_EQ(more.pending, 6u);
    EXPECT_EQ(more.received, 10u);
  }
}

TEST(Run, ACameraKeepsNoMask) {
  Greedy scheme;
  EXPECT_EQ(test::error_of(
                [&] { asap::Run run(scheme, {.keep_mask = true}, asap::Run::Source::camera); }),
            "keep_mask = 1: not with live events; give it to a recording's run");
  EXPECT_FALSE(asap::Run(scheme, {}, asap::Run::Source::camera).kept());
}

TEST(Run, AnAgeSlotIsA64thOfTheBound) {
  EXPECT_EQ(asap::Run::age_slot_ns(10'000'000), 156'250);
  EXPECT_EQ(asap::Run::age_slot_ns(10'000), 156);
  EXPECT_EQ(asap::Run::age_slot_ns(1), 1);
  // The slots reach back to twice the bound, whatever the rounding.
  for (const std::int64_t bound_ns : {10'000, 10'063, 9'999'999, 1'000'000'007}) {
    EXPECT_GT((AgeSlots::kSlots + 1) * asap::Run::age_slot_ns(bound_ns), 19 * bound_ns / 10);
  }
}

}  // namespace
}  // namespace asap::run_test
