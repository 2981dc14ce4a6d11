#include "ros/bridge/facts.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace asap::ros::facts_test {
namespace {

TEST(Facts, NamesWithADotBecomeObjects) {
  const Facts facts{text("state", "open"),
                    {"ledger.received", number(std::uint64_t{3})},
                    {"ledger.pending", number(std::uint64_t{0})},
                    {"gamma.mean", number(0.5)},
                    {"cpu", number(std::numeric_limits<double>::quiet_NaN())}};
  EXPECT_EQ(
      to_json(facts),
      R"({"state": "open", "ledger": {"received": 3, "pending": 0}, "gamma": {"mean": 0.5}, "cpu": null})");
  EXPECT_EQ(to_json({}), "{}");
  EXPECT_EQ(to_json({{"a.b", "1"}}), R"({"a": {"b": 1}})");
}

TEST(Facts, TextsAreQuoted) {
  EXPECT_EQ(to_json({text("a", "b \"c\" \\ \n")}), R"({"a": "b \"c\" \\ \u000a"})");
}

TEST(Facts, ALedgerIsASentence) {
  EXPECT_EQ(sentence(Ledger{}), "received 0 = 0");
  EXPECT_EQ(sentence(Ledger{.received = 10, .discarded = 3, .delivered = 7}),
            "received 10 = delivered 7 + discarded 3");
  EXPECT_EQ(sentence(Ledger{.received = 10, .delivered = 7}),
            "received 10 = delivered 7 (does not add up)");
}

}  // namespace
}  // namespace asap::ros::facts_test
