#include "ros/bridge/feedback_gate.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>
#include <thread>
#include <vector>

namespace asap::ros::feedback_gate_test {
namespace {

using namespace std::chrono_literals;

TEST(FeedbackGate, RefusesWhatIsNoTimeOrNotOfThisPackageAndSaysWhy) {
  FeedbackGate gate;
  const auto refusal = [&](std::uint64_t seq, double seconds) {
    EXPECT_FALSE(gate.feedback("a", seq, seconds));
    return gate.counts().refusal;
  };
  EXPECT_EQ(refusal(7, .001),
            "seq = 7: the newest package has 0; give the seq of the package's message");
  EXPECT_EQ(refusal(0, .001), "seq = 0: no package is in flight");
  gate.sent(7);
  EXPECT_EQ(refusal(7, std::numeric_limits<double>::quiet_NaN()),
            "time = nan: must be seconds, 0 or more");
  EXPECT_EQ(refusal(7, -1e-9), "time = -1e-09: must be seconds, 0 or more");
  EXPECT_TRUE(refusal(7, 3600.0).starts_with("time = 3600: the package left "));
  EXPECT_TRUE(gate.feedback("a", 7, 0.0));
  EXPECT_EQ(refusal(7, 0.0), "seq = 7: finished before; give feedback once");
  EXPECT_EQ(gate.counts().refused, 6u);
}

TEST(FeedbackGate, FeedbackNamesItsMessage) {
  FeedbackGate gate;
  gate.set_patience(1ms);
  gate.sent(1);
  gate.wait();
  gate.sent(2);
  EXPECT_FALSE(gate.feedback("a", 1, 0.0));
  EXPECT_EQ(gate.counts().refusal, "seq = 1: too late, its time was up");
  EXPECT_FALSE(gate.feedback("a", 3, 0.0));
  EXPECT_TRUE(gate.feedback("a", 2, 0.0));
  gate.sent(3);
  EXPECT_TRUE(gate.feedback("a", 0, 0.0));  // from one that does not tell
  EXPECT_EQ(gate.counts().refused, 2u);
}

TEST(FeedbackGate, TheSlowestConsumerSetsThePaceUntilItLeaves) {
  FeedbackGate gate;
  gate.set_patience(1min);
  gate.sent(1);
  EXPECT_TRUE(gate.feedback("fast", 1, 0.0));
  gate.wait();
  EXPECT_FALSE(gate.feedback("slow", 1, 0.0)) << "not known before";
  gate.sent(2);
  EXPECT_TRUE(gate.feedback("fast", 2, 0.0));
  EXPECT_EQ(gate.counts().consumers, 2u);
  const auto start = FeedbackGate::Clock::now();
  std::jthread slow([&] {
    std::this_thread::sleep_for(20ms);
    gate.feedback("slow", 2, 0.01);
  });
  gate.wait();
  EXPECT_GE(FeedbackGate::Clock::now() - start, 20ms);
  EXPECT_FALSE(gate.counts().stalled);
  gate.set_patience(1ms);
  gate.sent(3);
  EXPECT_TRUE(gate.feedback("fast", 3, 0.0));
  gate.wait();  // the slow one has left
  EXPECT_TRUE(gate.counts().stalled);
  EXPECT_EQ(gate.counts().timeouts, 1u);
  EXPECT_EQ(gate.counts().left_out, std::vector<std::string>{"slow"});
  gate.set_patience(1min);
  gate.sent(4);
  EXPECT_TRUE(gate.feedback("fast", 4, 0.0));
  gate.wait();
  EXPECT_FALSE(gate.counts().stalled);
  EXPECT_EQ(gate.counts().consumers, 1u);
  gate.sent(5);
  EXPECT_TRUE(gate.feedback("slow", 5, 0.0));
  EXPECT_TRUE(gate.counts().left_out.empty());
}

TEST(FeedbackGate, AnotherPatienceHoldsForThePackageInFlight) {
  FeedbackGate gate;
  gate.set_patience(1h);
  gate.sent(1);
  std::jthread operating([&] {
    std::this_thread::sleep_for(5ms);
    gate.set_patience(1ms);
  });
  gate.wait();
  EXPECT_EQ(gate.counts().timeouts, 1u);
}

}  // namespace
}  // namespace asap::ros::feedback_gate_test
