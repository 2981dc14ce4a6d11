#include "algorithms/sensor_frame.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "support/errors.hpp"

namespace sensor_frame_test {
namespace {

using asap::Event;
using asap::SensorFrame;

Event at(std::uint16_t x, std::uint16_t y) { return {.x = x, .y = y, .p = 0, .t = 0}; }

TEST(SensorFrame, KnowsItsPixels) {
  const SensorFrame frame(20, 10);
  EXPECT_TRUE(frame.contains(at(0, 0)));
  EXPECT_TRUE(frame.contains(at(19, 9)));
  EXPECT_FALSE(frame.contains(at(20, 9)));
  EXPECT_FALSE(frame.contains(at(19, 10)));
  EXPECT_FALSE(frame.contains(at(65535, 65535)));
}

TEST(SensorFrame, KnowsTheEventsAwayFromTheBorder) {
  const SensorFrame frame(20, 10);
  EXPECT_TRUE(frame.contains(at(4, 4), 4));
  EXPECT_TRUE(frame.contains(at(15, 5), 4));
  EXPECT_FALSE(frame.contains(at(3, 5), 4));
  EXPECT_FALSE(frame.contains(at(16, 5), 4));
  EXPECT_FALSE(frame.contains(at(10, 3), 4));
  EXPECT_FALSE(frame.contains(at(10, 6), 4));
  EXPECT_FALSE(SensorFrame(1, 1).contains(at(0, 0), 1));
}

TEST(SensorFrame, NamesBadSides) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { SensorFrame(0, 10); }), "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of([] { SensorFrame(10, -1); }), "height = -1: must be 1 to 16384 px");
  EXPECT_EQ(error_of([] { SensorFrame(16385, 10); }), "width = 16385: must be 1 to 16384 px");
  EXPECT_NO_THROW(SensorFrame(16384, 1));
}

}  // namespace
}  // namespace sensor_frame_test
