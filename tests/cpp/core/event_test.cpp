#include "asap/core/event.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace asap::event_test {
namespace {

TEST(Event, LiesInMemoryLikeEventCD) {
  const Event event{0x0201, 0x0403, 0x0605, 0x1817161514131211};
  unsigned char bytes[sizeof event];
  std::memcpy(bytes, &event, sizeof event);
  const unsigned char expected[] = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06};
  EXPECT_EQ(std::memcmp(bytes, expected, sizeof expected), 0);
  for (unsigned char i = 0; i < 8; ++i) EXPECT_EQ(bytes[8 + i], 0x11 + i);
}

TEST(Event, ComparesFieldsAndNotThePadding) {
  Event a;
  Event b;
  std::memset(static_cast<void*>(&a), 0x00, sizeof a);
  std::memset(static_cast<void*>(&b), 0xff, sizeof b);
  a.x = b.x = 1;
  a.y = b.y = 2;
  a.p = b.p = 1;
  a.t = b.t = 4;
  EXPECT_NE(std::memcmp(&a, &b, sizeof a), 0);
  EXPECT_EQ(a, b);
}

TEST(Event, DiffersInEveryField) {
  const Event event{1, 2, 0, 4};
  EXPECT_NE(event, (Event{9, 2, 0, 4}));
  EXPECT_NE(event, (Event{1, 9, 0, 4}));
  EXPECT_NE(event, (Event{1, 2, 1, 4}));
  EXPECT_NE(event, (Event{1, 2, 0, 9}));
}

}  // namespace
}  // namespace asap::event_test
