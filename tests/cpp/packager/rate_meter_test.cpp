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
