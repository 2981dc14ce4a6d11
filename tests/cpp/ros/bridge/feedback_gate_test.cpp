#include "ros/bridge/feedback_gate.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>

namespace asap::ros::feedback_gate_test {
namespace {

using namespace std::chrono_literals;

TEST(FeedbackGate, WaitsForTheFeedback) {
  FeedbackGate gate;
  gate.sent(7);
  std::jthread consumer([&] {
    std::this_thread::sleep_for(5ms);
    EXPECT_TRUE(gate.feedback(7, 0.001));
  });
  gate.wait(10min);
  EXPECT_EQ(gate.counts().taken, 1u);
  EXPECT_EQ(gate.counts().timeouts, 0u);
}

TEST(FeedbackGate, TakesFeedbackThatComesBeforeTheWait) {
  FeedbackGate gate;
  gate.sent(7);
  EXPECT_TRUE(gate.feedback(7, 0.0));
  gate.wait(10min);
  EXPECT_EQ(gate.counts().timeouts, 0u);
}

TEST(FeedbackGate, GoesOnWithoutFeedback) {
  FeedbackGate gate;
  gate.sent(7);
  gate.wait(1ms);
  EXPECT_EQ(gate.counts().timeouts, 1u);
  EXPECT_TRUE(gate.counts().stalled);
  EXPECT_FALSE(gate.feedback(7, 0.0));  // its time was up
  gate.sent(7);
  EXPECT_TRUE(gate.feedback(7, 0.0));
  gate.wait(10min);
  EXPECT_FALSE(gate.counts().stalled);
}

TEST(FeedbackGate, RefusesWhatIsNoTimeOrNotOfThisPackage) {
  FeedbackGate gate;
  EXPECT_FALSE(gate.feedback(7, 0.001));
  gate.sent(7);
  EXPECT_FALSE(gate.feedback(7, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(gate.feedback(7, std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(gate.feedback(7, -1e-9));
  EXPECT_FALSE(gate.feedback(7, 3600.0));  // of an earlier package
  EXPECT_EQ(gate.counts().refused, 5u);
  EXPECT_TRUE(gate.feedback(7, 0.0));
  EXPECT_FALSE(gate.feedback(7, 0.0));  // twice
}

TEST(FeedbackGate, FeedbackNamesItsMessage) {
  FeedbackGate gate;
  gate.sent(1);
  gate.wait(1ms);
  gate.sent(2);
  EXPECT_FALSE(gate.feedback(1, 0.0));  // late
  EXPECT_FALSE(gate.feedback(3, 0.0));
  EXPECT_TRUE(gate.feedback(2, 0.0));
  gate.sent(3);
  EXPECT_TRUE(gate.feedback(0, 0.0));  // from one that does not tell
  EXPECT_EQ(gate.counts().refused, 2u);
}

TEST(FeedbackGate, NoWaitOutlivesItsClosing) {
  FeedbackGate gate;
  std::jthread other([&] {
    std::this_thread::sleep_for(5ms);
    gate.close();
  });
  gate.sent(7);
  gate.wait(10min);
  gate.pause(FeedbackGate::Clock::now() + 10min);
  EXPECT_EQ(gate.counts().timeouts, 0u);
  gate.open();
  gate.pause(FeedbackGate::Clock::now() + 1ms);
  gate.sent(7);
  gate.wait(1ms);
  EXPECT_EQ(gate.counts().timeouts, 1u);
}

}  // namespace
}  // namespace asap::ros::feedback_gate_test
