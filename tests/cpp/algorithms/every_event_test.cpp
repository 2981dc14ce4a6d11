#include "asap/algorithms/every_event.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace every_event_test {
namespace {

TEST(EveryEvent, OfTheFrameIsACorner) {
  asap::EveryEvent detector({.width = 4, .height = 3});
  const std::vector<asap::Event> events{{.x = 0, .y = 0, .p = 0, .t = 0},
                                        {.x = 4, .y = 0, .p = 0, .t = 0},
                                        {.x = 3, .y = 2, .p = 1, .t = -5},
                                        {.x = 0, .y = 3, .p = 1, .t = 0}};
  std::vector<std::uint8_t> labels(4);
  detector.process(events, labels);
  EXPECT_EQ(labels, (std::vector<std::uint8_t>{1, 0, 1, 0}));
  EXPECT_EQ(detector.rejected(), 2U);
}

}  // namespace
}  // namespace every_event_test
