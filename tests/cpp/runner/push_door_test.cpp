#include "runner/push_door.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace asap::push_door_test {
namespace {

// Says whether who leaves is the last one out.
bool leaves_last(PushDoor& door) {
  bool last = false;
  door.leave([&] { last = true; });
  return last;
}

TEST(PushDoor, IsShutUntilOpened) {
  PushDoor door;
  EXPECT_FALSE(door.enter());
  EXPECT_FALSE(door.shut()) << "it was not open";
  door.open();
  EXPECT_TRUE(door.enter());
  EXPECT_FALSE(leaves_last(door));
  EXPECT_TRUE(door.enter()) << "the one before has left";
  EXPECT_FALSE(leaves_last(door));
  EXPECT_TRUE(door.shut());
  EXPECT_FALSE(door.is_open());
  EXPECT_FALSE(door.enter());
}

TEST(PushDoor, HoldsOneAtATime) {
  PushDoor door;
  door.open();
  EXPECT_TRUE(door.enter());
  EXPECT_FALSE(door.enter());
  EXPECT_FALSE(door.enter()) << "who was not let in does not let others in";
}

TEST(PushDoor, TheLastOneOutIsTheOneInside) {
  PushDoor door;
  door.open();
  ASSERT_TRUE(door.enter());
  EXPECT_FALSE(door.shut());
  EXPECT_FALSE(door.is_open());
  EXPECT_FALSE(door.shut()) << "nor the second time";
  EXPECT_FALSE(door.enter());
  EXPECT_TRUE(leaves_last(door));
  door.wait_until_empty();
  EXPECT_FALSE(door.enter());
}

TEST(PushDoor, OneIsTheLastOutAndThenNobodyIsInside) {
  PushDoor door;
  int written = 0;  // a race, unless the door is right
  int ends = 0;
  for (int round = 0; round < 200; ++round) {
    door.open();
    std::jthread producer([&] {
      while (door.enter()) {
        ++written;
        door.leave([&] { ++ends; });
      }
    });
    std::this_thread::yield();
    if (door.shut()) ++ends;
    door.wait_until_empty();
    ASSERT_EQ(ends, round + 1);
    const int seen = written;
    producer.join();
    ASSERT_EQ(written, seen);
  }
}

}  // namespace
}  // namespace asap::push_door_test
