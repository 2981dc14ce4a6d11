#include "algorithms/fast/support_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "asap/algorithms/background_activity_filter.hpp"
#include "asap/core/random.hpp"

namespace support_map_test {
namespace {

using asap::fast::Stamp;
using asap::fast::SupportMap;

TEST(SupportMap, CountsTheEightNeighboursAndNotTheOwnPixel) {
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      SupportMap map(20, 20);
      map.clear(1000);
      EXPECT_FALSE(map.touch(10, 10, 1000, 50));
      const bool neighbour = std::max(std::abs(dx), std::abs(dy)) == 1;
      const auto x = static_cast<std::size_t>(10 + dx);
      const auto y = static_cast<std::size_t>(10 + dy);
      EXPECT_EQ(map.touch(x, y, 1050, 50), neighbour) << dx << ' ' << dy;
    }
  }
}

TEST(SupportMap, TheWindowIsInclusive) {
  SupportMap map(20, 20);
  map.clear(1000);
  map.touch(10, 10, 1000, 50);
  EXPECT_FALSE(map.touch(11, 10, 1051, 50));
  EXPECT_TRUE(map.touch(12, 10, 1101, 50));
}

// Every frame, every start: the same as the filter, which has 64-bit time.
TEST(SupportMap, AgreesWithTheFilterAcrossTheWrapAndAtTheBorder) {
  const asap::CounterRandom random(3);
  for (const std::int64_t start : {0LL, 0x7fff'ff00LL, 0xffff'ff00LL}) {
    SupportMap map(5, 4);
    asap::BackgroundActivityFilter filter({.width = 5, .height = 4, .window_us = 30});
    map.clear(static_cast<Stamp>(start));
    std::int64_t t = start;
    for (std::uint64_t i = 0; i < 5000; ++i) {
      t += static_cast<std::int64_t>(random(3 * i) % 20);
      asap::Event event{.x = static_cast<std::uint16_t>(random(3 * i + 1) % 5),
                        .y = static_cast<std::uint16_t>(random(3 * i + 2) % 4),
                        .p = 0,
                        .t = t};
      const bool expected = filter.process({&event, 1}, &event) == 1;
      ASSERT_EQ(map.touch(event.x, event.y, static_cast<Stamp>(t), 30), expected) << i;
    }
  }
}

TEST(SupportMap, ScrubbingMakesNoOldEventYoungAgain) {
  SupportMap map(4, 4);
  map.clear(0);
  map.touch(1, 1, 0, 5000);
  std::uint64_t now_us = 0;
  for (int step = 0; step < 50; ++step) {
    now_us += 100'000'000;
    map.scrub(static_cast<Stamp>(now_us), 100'000'000);
    SupportMap copy = map;
    EXPECT_FALSE(copy.touch(2, 1, static_cast<Stamp>(now_us), 5000)) << step;
  }
}

}  // namespace
}  // namespace support_map_test
