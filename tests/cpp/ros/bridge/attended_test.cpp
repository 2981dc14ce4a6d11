#include "ros/bridge/attended.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "support/fake_backlog.hpp"
#include "support/outcomes.hpp"

namespace asap::ros::attended_test {
namespace {

constexpr double kAlpha_ns = 100'000, kBeta_ns = 50, kTimeout_ns = 1e9;

void observe(Attended& scheme, std::size_t size, double work_ns, bool is_away) {
  scheme.note(is_away);
  scheme.observe(test::package(size, work_ns));
}

TEST(Attended, LearnsNothingFromATimeout) {
  Attended scheme({});
  const auto work = [&](std::size_t size) {
    observe(scheme, size, kAlpha_ns + kBeta_ns * static_cast<double>(size), false);
  };
  const auto learned = [&] { return std::pair{scheme.law().alpha_ns(), scheme.law().beta_ns()}; };
  for (std::size_t size = 1'000; size < 101'000; size += 1'000) work(size);
  const auto before = learned();
  EXPECT_NEAR(before.first, kAlpha_ns, 0.1 * kAlpha_ns);
  EXPECT_NEAR(before.second, kBeta_ns, 0.1 * kBeta_ns);
  for (int i = 0; i < 10; ++i) observe(scheme, Attended::kWhileAway, kTimeout_ns, true);
  observe(scheme, Attended::kWhileAway, kTimeout_ns / 2, false);  // sent before it was back
  EXPECT_EQ(learned(), before);
  work(1'000'000);
  EXPECT_NE(learned(), before) << "it learns again";
}

TEST(Attended, DropsAllButLittleWhileTheConsumerIsAway) {
  Attended scheme({});
  const auto backlog = test::FakeBacklog::of(3 * Attended::kWhileAway);
  EXPECT_EQ(scheme.decide(backlog.at(0, true)).stale, 0u);
  scheme.note(true);
  EXPECT_EQ(scheme.decide(backlog.at(0, true)).stale, 2 * Attended::kWhileAway);
  scheme.note(false);
  EXPECT_EQ(scheme.decide(backlog.at(0, true)).stale, 0u);
}

}  // namespace
}  // namespace asap::ros::attended_test
