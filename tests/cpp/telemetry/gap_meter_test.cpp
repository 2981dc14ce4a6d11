#include "telemetry/gap_meter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "core/random.hpp"
#include "support/streams.hpp"

namespace asap::gap_meter_test {
namespace {

using test::at_times;
using test::Events;

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
