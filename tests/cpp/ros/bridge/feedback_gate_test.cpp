#include "ros/bridge/feedback_gate.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>

namespace asap::ros::feedback_gate_test {
namespace {

using namespace std::chrono_literals;

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

}  // namespace
}  // namespace asap::ros::feedback_gate_test
