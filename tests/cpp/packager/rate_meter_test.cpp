#include "packager/rate_meter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/streams.hpp"

namespace asap::rate_meter_test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

TEST(RateMeter, ReadsZeroBeforeTheFirstObservation) { EXPECT_EQ(RateMeter().per_second(), 0.0); }

TEST(RateMeter, ReadsASteadyRateFromItsFirstMillisecondOn) {
  for (const std::int64_t step_ns : {100, 1000, 50'000}) {
    for (const std::size_t count : {1u, 10u, 1000u}) {
      RateMeter meter;
      const auto size = static_cast<std::int64_t>(count);
      for (std::int64_t i = 0; i < 500; ++i) {
        const std::int64_t oldest_ns = i * size * step_ns;
        const std::int64_t newest_ns = oldest_ns + (size - 1) * step_ns;
        meter.observe(count, oldest_ns, newest_ns);
        if (newest_ns >= kMillisecond) {
          ASSERT_NEAR(meter.per_second(), 1e9 / static_cast<double>(step_ns), 1e-3)
              << "package " << i << " of " << count;
        }
      }
    }
  }
}

TEST(RateMeter, CountsTheFirstMillisecondAsOne) {
  RateMeter meter;
  meter.observe(600, 0, 0);
  EXPECT_DOUBLE_EQ(meter.per_second(), 6e5);
  meter.observe(100, 1000, 900'000);
  EXPECT_DOUBLE_EQ(meter.per_second(), 7e5);
}

// Bands of equal stamps as real sensors give them: 600 events every 500 us are 1.2 Mev/s.
TEST(RateMeter, A6_DoesNotSpikeOnBandsOfEqualStamps) {
  for (const std::size_t size : {1u, 100u, 600u}) {
    RateMeter meter;
    for (std::int64_t stamp_ns = 0; stamp_ns < 100 * kMillisecond; stamp_ns += 500'000) {
      for (std::size_t i = 0; i < 600; i += size) {
        meter.observe(size, stamp_ns, stamp_ns);
        ASSERT_LE(meter.per_second(), 1.2e6 * 1.001);
        if (stamp_ns >= kMillisecond) {
          ASSERT_NEAR(meter.per_second(), 1.2e6, 1.0);
        }
      }
    }
  }
}

TEST(RateMeter, A6_PackagesAcrossBandsStayNearTheRate) {
  RateMeter meter;
  std::vector<std::int64_t> stamps_ns;
  for (std::int64_t i = 0; i < 200 * 600; ++i) stamps_ns.push_back(i / 600 * 500'000);
  for (std::size_t i = 0; i + 250 <= stamps_ns.size(); i += 250) {
    meter.observe(250, stamps_ns[i], stamps_ns[i + 249]);
    ASSERT_LE(meter.per_second(), 1.2e6 + 250 / 0.001);
    if (stamps_ns[i] >= kMillisecond) {
      ASSERT_NEAR(meter.per_second(), 1.2e6, 250 / 0.001);
    }
  }
}

TEST(RateMeter, ReadsSingleEventsOfAQuietScene) {
  RateMeter meter;
  meter.observe(1, 0, 0);
  EXPECT_DOUBLE_EQ(meter.per_second(), 1000.0);  // one in the first millisecond
  for (std::int64_t i = 1; i < 100; ++i) {
    meter.observe(1, 100 * i * kMillisecond, 100 * i * kMillisecond);
    ASSERT_DOUBLE_EQ(meter.per_second(), 10.0);
  }
}

TEST(RateMeter, A10_RecoversWithinTwoMillisecondsAfterSilence) {
  RateMeter meter;
  std::int64_t now_ns = 0;
  const auto run = [&](std::int64_t until_ns) {  // 1 Mev/s in packages of 20
    for (; now_ns < until_ns; now_ns += 20'000) meter.observe(20, now_ns, now_ns + 19'000);
  };
  run(10 * kMillisecond);
  EXPECT_NEAR(meter.per_second(), 1e6, 1.0);
  now_ns = 10'000 * kMillisecond;
  meter.observe(1, now_ns, now_ns);
  EXPECT_LT(meter.per_second(), 1000.0);  // hardly anything in ten seconds
  now_ns += 1000;
  run(10'002 * kMillisecond);
  EXPECT_NEAR(meter.per_second(), 1e6, 1e4);
}

// All that was observed, in a list. The window may begin at any package that ended 1 ms ago, or up
// to a sixteenth of a millisecond before that.
class NaiveMeter {
 public:
  void observe(std::size_t count, std::int64_t oldest_ns, std::int64_t newest_ns) {
    if (ends_.empty()) ends_.push_back({oldest_ns, 0});
    const std::uint64_t before = total_ + (oldest_ns < newest_ns ? count - 1 : 0);
    if (newest_ns > ends_.back().time_ns) ends_.push_back({newest_ns, before});
    total_ += count;
  }

  bool allows(double rate) const {
    const End& newest = ends_.back();
    const auto old_enough = [&](const End& end) {
      return newest.time_ns - end.time_ns >= kMillisecond;
    };
    auto end = std::find_if(ends_.rbegin(), ends_.rend(), old_enough);
    if (end == ends_.rend()) return near(rate, static_cast<double>(total_) * 1e3);
    const std::int64_t latest_ns = end->time_ns;
    for (; end != ends_.rend() && latest_ns - end->time_ns < kMillisecond / 16; ++end) {
      const auto elapsed_ns = static_cast<double>(newest.time_ns - end->time_ns);
      if (near(rate, static_cast<double>(newest.before - end->before) * 1e9 / elapsed_ns)) {
        return true;
      }
    }
    return false;
  }

 private:
  struct End {
    std::int64_t time_ns;
    std::uint64_t before;
  };
  static bool near(double a, double b) { return std::abs(a - b) <= 1e-9 * b; }

  std::vector<End> ends_;
  std::uint64_t total_ = 0;
};

TEST(RateMeter, AgreesWithACountOverRandomStreams) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(1000 + seed);
    const test::Events events = test::random_stream(seed, 20'000);
    RateMeter meter;
    NaiveMeter naive;
    for (std::size_t at = 0; at < events.size();) {
      const std::size_t size =
          std::min(1 + random(at) % (seed % 2 == 0 ? 3 : 200), events.size() - at);
      const std::int64_t oldest_ns = 1000 * events[at].t;
      const std::int64_t newest_ns = 1000 * events[at + size - 1].t;
      meter.observe(size, oldest_ns, newest_ns);
      naive.observe(size, oldest_ns, newest_ns);
      at += size;
      ASSERT_TRUE(std::isfinite(meter.per_second()));
      ASSERT_TRUE(naive.allows(meter.per_second()))
          << meter.per_second() << " at event " << at << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace asap::rate_meter_test
