#include "algorithms/fast/stamp.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <vector>

namespace stamp_test {
namespace {

using asap::fast::age_us;
using asap::fast::kLongAgo_us;
using asap::fast::long_before;
using asap::fast::Scrubber;
using asap::fast::Stamp;

TEST(Stamp, AgesAreDifferencesAcrossTheWrap) {
  EXPECT_EQ(age_us(5, 0xfffffffbU), 10);
  EXPECT_EQ(age_us(0xfffffffbU, 5), -10);
  EXPECT_EQ(age_us(3, long_before(3)), kLongAgo_us);
}

TEST(Scrubber, VisitsEveryEntryOncePerRound) {
  for (const std::uint64_t step_us : {2'000ULL, 1'234'567ULL, 400'000'000ULL}) {
    Scrubber scrubber(1000);
    std::vector<int> visits(1000);
    const auto count = [&](std::size_t first, std::size_t n) {
      for (std::size_t i = first; i < first + n; ++i) ++visits.at(i);
    };
    for (std::uint64_t t = 0; t < Scrubber::kRound_us; t += step_us) {
      scrubber.advance(std::min(step_us, Scrubber::kRound_us - t), count);
    }
    EXPECT_EQ(visits, std::vector<int>(1000, 1)) << step_us;
  }
}

TEST(Scrubber, ASilenceOfAnyLengthVisitsAllOnce) {
  Scrubber scrubber(10);
  std::size_t visits = 0;
  scrubber.advance(~std::uint64_t{0}, [&](std::size_t, std::size_t n) { visits += n; });
  EXPECT_EQ(visits, 10U);
}

TEST(Scrub, KeepsOldEntriesOldForHours) {
  std::vector<Stamp> stamps{0};
  Scrubber scrubber(stamps.size());
  std::uint64_t now_us = 0;
  for (int hour = 0; hour < 40; ++hour) {
    now_us += 300'000'000;
    const auto now = static_cast<Stamp>(now_us);
    scrubber.advance(300'000'000, [&](std::size_t first, std::size_t n) {
      asap::fast::scrub(stamps.data() + first, n, now, [](Stamp& s) -> Stamp& { return s; });
    });
    EXPECT_GE(age_us(now, stamps[0]), 300'000'000);
  }
}

}  // namespace
}  // namespace stamp_test
