#include "ros/bridge/facts.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/greedy.hpp"

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

TEST(Facts, SharesOfNothingAreUnknown) {
  Greedy scheme;
  const std::string json = to_json(facts_of(Pipeline(scheme, {.capacity = 64}).stats()));
  for (const char* share : {"\"kept\": null", "\"in_time\": null"}) {
    EXPECT_NE(json.find(share), std::string::npos) << json;
  }
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
