#include "study/clipper_aimd.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/errors.hpp"
#include "support/fake_backlog.hpp"

namespace asap::clipper_aimd_test {
namespace {

using test::FakeBacklog;

std::size_t limit(ClipperAimd& scheme) {
  const Decision decision = scheme.decide(FakeBacklog::of(1000).at(0));
  EXPECT_TRUE(decision.takes);
  EXPECT_EQ(decision.keep, 1.0);
  EXPECT_EQ(decision.stale, 0u);
  return decision.raw;
}

std::size_t limit_after(ClipperAimd& scheme, std::size_t size, std::int64_t processing_ns) {
  scheme.observe(
      {.size = size, .raw = size, .span_ns = 0, .start_ns = 0, .processing_ns = processing_ns});
  return limit(scheme);
}

TEST(ClipperAimd, GrowsByFiftyAfterAFullPackageInTime) {
  ClipperAimd scheme(10);
  EXPECT_EQ(limit(scheme), 50u);
  EXPECT_EQ(limit_after(scheme, 50, 5'000'000), 100u);
  EXPECT_EQ(limit_after(scheme, 99, 1), 100u);  // was not full
  EXPECT_EQ(limit_after(scheme, 100, 1), 150u);
  EXPECT_EQ(scheme.decide(FakeBacklog::of(20).at(0)).raw, 20u);
}

TEST(ClipperAimd, ShrinksByATenthAfterALatePackage) {
  ClipperAimd scheme(10);
  EXPECT_EQ(limit_after(scheme, 50, 5'000'001), 45u);
  EXPECT_EQ(limit_after(scheme, 3, 9'000'000), 40u);  // 40.5, full or not
  EXPECT_EQ(limit_after(scheme, 40, 1), 90u);         // 90.5
  for (int k = 0; k < 100; ++k) limit_after(scheme, 1, 9'000'000);
  EXPECT_EQ(limit(scheme), 1u);
  EXPECT_EQ(limit_after(scheme, 1, 1), 51u);
}

TEST(ClipperAimd, IsNotWedgedByAbsurdOutcomes) {
  ClipperAimd scheme(10);
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  for (int k = 0; k < 1000; ++k) {
    ASSERT_GE(limit_after(scheme, k % 2 == 0 ? 0 : 7, kMost), 1u);
    ASSERT_GE(limit_after(scheme, 0, -kMost), 1u);
  }
}

TEST(ClipperAimd, ResetBringsTheFirstStateBack) {
  ClipperAimd scheme(10);
  limit_after(scheme, 50, 1);
  scheme.reset(Execution::whole);
  EXPECT_EQ(limit(scheme), 50u);
}

TEST(ClipperAimd, TellsItsNameAndBound) {
  const ClipperAimd scheme(7.5);
  EXPECT_EQ(scheme.name(), "clipper_aimd");
  EXPECT_EQ(scheme.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  EXPECT_EQ(scheme.latency_bound_ns(), 7'500'000);
  EXPECT_EQ(test::error_of([] { ClipperAimd bad(0); }).substr(0, 16), "latency_ms = 0: ");
}

}  // namespace
}  // namespace asap::clipper_aimd_test
