#include "ros/bridge/parameters.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "asap/schemes/deadline.hpp"
#include "support/errors.hpp"

namespace asap::ros::parameters_test {
namespace {

std::string error(const Parameters& parameters) {
  return test::error_of([&] { check(parameters); });
}

TEST(Parameters, TheDefaultsAreGood) { EXPECT_EQ(error({}), "nothing was thrown"); }

TEST(Parameters, ANumberOutsideItsRangeIsRefusedByName) {
  EXPECT_EQ(error({.latency_ms = 0.0}), "latency_ms = 0: must be between 0.1 and 10000");
  EXPECT_EQ(error({.rate_bound = -1.0}), "rate_bound = -1: must be between 0 and 1000000000");
  for (const NumberField& number : kNumbers) {
    Parameters parameters;
    parameters.*number.field = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(error(parameters).find(std::string(number.name) + " = nan: must be"), 0u);
    parameters.*number.field = number.max * 1.01;
    EXPECT_EQ(error(parameters).find(number.name), 0u);
  }
}

TEST(Parameters, TheTimeoutIsNotShorterThanTheBound) {
  EXPECT_EQ(error({.latency_ms = 50, .feedback_timeout_ms = 20, .feedback = "topic"}),
            "feedback_timeout_ms = 20: must be at least latency_ms = 50");
}

TEST(Parameters, WithoutFeedbackTheTimeoutDoesNotCount) {
  EXPECT_EQ(error({.latency_ms = 5'000, .feedback = "none"}), "nothing was thrown");
}

TEST(Parameters, ACountIsAWholeNumber) {
  EXPECT_EQ(error({.seed = 1.5}), "seed = 1.5: must be a whole number between 0 and 1e+15");
  EXPECT_EQ(error({.queue = 2.5}), "queue = 2.5: must be a whole number between 1 and 100000");
}

TEST(Parameters, AMisspeltNameIsRefusedAndAForeignOneIsNot) {
  EXPECT_EQ(test::error_of([] { is_foreign("latncy_ms", "5"); }),
            "latncy_ms = 5: the node has no such parameter; did you mean latency_ms?");
  for (const char* slip : {"latency", "latency_us", "feedback_timeout", "prefers", "Queue",
                           "input_reliabilty", "capcity", "rate_bounds", "warmup_discard"}) {
    EXPECT_THROW(is_foreign(slip, ""), std::invalid_argument) << slip;
  }
  for (const char* other :
       {"use_sim_time", "qos_overrides./events.subscription.depth", "speed", "fps", "rate",
        "bias_file", "frame_id", "serial", "erc_rate", "queue_size", "display_type", ""}) {
    EXPECT_TRUE(is_foreign(other, "")) << other;
  }
  EXPECT_FALSE(is_foreign("latency_ms", ""));
  EXPECT_FALSE(is_foreign("input_reliability", "")) << "in ROS 1 without effect";
}

TEST(Parameters, AChoiceIsOneOfItsNames) {
  EXPECT_EQ(error({.feedback = "tpoic"}), "feedback = tpoic: must be one of topic, service, none");
  EXPECT_EQ(error({.prefer = "all"}), "prefer = all: must be one of balanced, events, continuity");
  EXPECT_EQ(error({.encoding = ""}), "encoding = : must be one of evt3, mono, dvs_msgs");
  for (const ChoiceField& choice : kChoices) {
    for (const char* value : choice.choices) {
      Parameters parameters;
      parameters.*choice.field = value;
      EXPECT_EQ(error(parameters), "nothing was thrown");
    }
  }
}

TEST(Parameters, PreferHasTheNamesOfTheScheme) {
  for (const char* name : kPreferences) EXPECT_EQ(name_of(prefer_of(name)), name);
  EXPECT_EQ(std::size(kPreferences), static_cast<std::size_t>(Prefer::continuity) + 1);
  EXPECT_EQ(prefer_of(Parameters{}.prefer), DeadlineConfig{}.prefer);
}

}  // namespace
}  // namespace asap::ros::parameters_test
