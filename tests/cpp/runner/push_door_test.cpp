#include "asap/runner/push_door.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace asap {
namespace {

TEST(PushDoor, IsShutUntilOpened) {
  PushDoor door;
  EXPECT_FALSE(PushDoor::Visit(door).inside());
  door.open();
  EXPECT_TRUE(PushDoor::Visit(door).inside());
  EXPECT_TRUE(PushDoor::Visit(door).inside()) << "the one before has left";
  door.close();
  EXPECT_FALSE(door.is_open());
  EXPECT_FALSE(PushDoor::Visit(door).inside());
}

TEST(PushDoor, HoldsOneAtATime) {
  PushDoor door;
  door.open();
  const PushDoor::Visit first(door);
  EXPECT_FALSE(PushDoor::Visit(door).inside());
  EXPECT_FALSE(PushDoor::Visit(door).inside()) << "who was not let in does not let others in";
}

TEST(PushDoor, NobodyIsInsideWhenItHasClosed) {
  for (int round = 0; round < 200; ++round) {
    PushDoor door;
    door.open();
    int written_inside = 0;  // a race, unless the door is right
    std::jthread producer([&] {
      for (;;) {
        const PushDoor::Visit visit(door);
        if (!visit.inside()) return;
        ++written_inside;
      }
    });
    std::this_thread::yield();
    door.close();
    const int seen = written_inside;
    producer.join();
    ASSERT_EQ(written_inside, seen);
  }
}

}  // namespace
}  // namespace asap
