#include "telemetry/gap_meter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/random.hpp"
#include "support/streams.hpp"

namespace asap::gap_meter_test {
namespace {

using test::at_times;
using test::evenly_spaced;
using test::Events;

Events of(const Events& events, const std::vector<std::size_t>& which) {
  Events some;
  for (const std::size_t i : which) some.push_back(events[i]);
  return some;
}

TEST(GapMeter, ASilentCameraMakesNoGap) {
  GapMeter gap;
  EXPECT_EQ(gap.longest_us(), 0);
  gap.kept({});
  gap.kept(at_times({10, 20, 5000}));
  gap.kept(at_times({90'000}));
  EXPECT_EQ(gap.longest_us(), 0);
  const Events events = at_times({100'000, 200'000, 200'001, 200'003, 300'000});
  gap.thinned(events, of(events, {0, 1, 3, 4}));
  EXPECT_EQ(gap.longest_us(), 3) << "200 to 203 ms: none of the long silences lost an event";
}

TEST(GapMeter, LostEventsMakeAGapFromTheKeptOneBeforeToTheNext) {
  GapMeter gap;
  gap.kept(at_times({0, 10}));
  gap.lost(at_times({15}));
  EXPECT_EQ(gap.longest_us(), 5) << "so far";
  gap.lost(at_times({20, 30}));
  EXPECT_EQ(gap.longest_us(), 20);
  gap.kept(at_times({45, 1000}));
  EXPECT_EQ(gap.longest_us(), 35);
  gap.lost(at_times({1030}));
  gap.kept(at_times({1034}));
  EXPECT_EQ(gap.longest_us(), 35) << "the shorter one came later";
}

TEST(GapMeter, TheFirstAndTheLastEventCountAsKept) {
  GapMeter first;
  first.lost(at_times({100, 150}));
  first.kept(at_times({400}));
  EXPECT_EQ(first.longest_us(), 300);

  GapMeter last;
  last.kept(at_times({100}));
  last.lost(at_times({150, 320}));
  EXPECT_EQ(last.longest_us(), 220);

  GapMeter none;
  none.lost(at_times({-50, 0, 70}));
  EXPECT_EQ(none.longest_us(), 120);

  GapMeter thinned;
  const Events events = at_times({7, 40, 50, 90});
  thinned.thinned(events, of(events, {2}));
  EXPECT_EQ(thinned.longest_us(), 43);
}

TEST(GapMeter, AStreamMayBeginBeforeTheFirstEventThatIsReported) {
  GapMeter gap;
  gap.begin(100);
  gap.lost(at_times({150}));
  gap.kept(at_times({160}));
  EXPECT_EQ(gap.longest_us(), 60);
  GapMeter whole;
  whole.begin(100);
  whole.kept(at_times({160}));
  EXPECT_EQ(whole.longest_us(), 0) << "nothing was lost before it";
}

TEST(GapMeter, AGapMayReachOverPackages) {
  GapMeter gap;
  const Events first = evenly_spaced(10, 10);
  const Events second = evenly_spaced(10, 10, 100);
  gap.thinned(first, of(first, {0, 1, 2, 3, 4, 5}));
  gap.thinned(second, {});
  gap.thinned(evenly_spaced(2, 10, 200), at_times({}));
  const Events third = evenly_spaced(10, 10, 220);
  gap.thinned(third, of(third, {3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(gap.longest_us(), 250 - 50);
}

TEST(GapMeter, EventsOfOneStampAreToldApart) {
  const Events events = at_times({0, 50, 50, 50, 90});
  for (const auto& [kept, longest_us] : std::vector<std::pair<std::vector<std::size_t>, int>>{
           {{0, 1, 2, 3, 4}, 0},
           {{0, 1, 2, 4}, 40},
           {{0, 1, 3, 4}, 0},  // the lost one lies between two of its own stamp
           {{0, 2, 3, 4}, 50},
           {{0, 4}, 90}}) {
    GapMeter gap;
    gap.thinned(events, of(events, kept));
    EXPECT_EQ(gap.longest_us(), longest_us) << kept.size() << " kept";
  }
}

// What the meter says of a stream in packages is what a look at every event finds.
TEST(GapMeter, AgreesWithALookAtEveryEvent) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const CounterRandom random(seed + 1000);
    const Events events = test::random_stream(seed, 3000);
    GapMeter gap;
    std::int64_t longest_us = 0;
    std::int64_t kept_until_us = events.front().t;
    bool is_lost = false;
    for (std::size_t begin = 0, package = 0; begin < events.size(); ++package) {
      const std::uint64_t bits = random(package);
      const std::size_t size = std::min<std::size_t>(1 + bits % 700, events.size() - begin);
      const EventSpan came = EventSpan(events).subspan(begin, size);
      const std::uint64_t most = bits >> 16 & 1 ? 100 : (bits >> 20) % 100;  // percent kept
      Events kept;
      for (std::size_t i = 0; i < size; ++i) {
        const std::int64_t t = came[i].t;
        const bool is_kept = random((package + 1) * 10'000 + i) % 100 < most;
        if (is_kept) kept.push_back(came[i]);
        if (is_lost || !is_kept) longest_us = std::max(longest_us, t - kept_until_us);
        if (is_kept) kept_until_us = t;
        is_lost = !is_kept;
      }
      if (kept.empty()) {
        gap.lost(came);
      } else if (kept.size() == size) {
        gap.kept(came);
      } else {
        gap.thinned(came, kept);
      }
      ASSERT_EQ(gap.longest_us(), longest_us) << "seed " << seed << ", package " << package;
      begin += size;
    }
  }
}

}  // namespace
}  // namespace asap::gap_meter_test
