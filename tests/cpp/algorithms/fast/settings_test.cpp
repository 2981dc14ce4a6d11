#include "algorithms/fast/settings.hpp"

#include <gtest/gtest.h>

namespace settings_test {
namespace {

using asap::ClusterTrackerConfig;
using asap::fast::Settings;

constexpr ClusterTrackerConfig kConfig{.width = 346, .height = 260};

TEST(Settings, AreTheConfigurationInOtherUnits) {
  const Settings s(kConfig);
  EXPECT_EQ(s.tick_us, 1000);
  EXPECT_EQ(s.link_us, 40'000);
  EXPECT_EQ(s.support_window_us, 5000);
  EXPECT_FLOAT_EQ(s.life.mass_s, 0.03F);
  EXPECT_FLOAT_EQ(s.life.coast_s, 0.25F);
  EXPECT_EQ(s.update.mean_events, 60U);
  EXPECT_EQ(s.update.contour_mask, 3U);
  EXPECT_TRUE(s.rejects);
}

TEST(Settings, MemoriesOfEventsFollowTheKeptFraction) {
  Settings s(kConfig);
  const auto told = [&](double gamma) {
    s.set_keep(kConfig, gamma, false);
    return s.update.mean_events;
  };
  EXPECT_EQ(told(0.5), 60U);
  EXPECT_EQ(told(0.25), 30U);
  EXPECT_EQ(s.kalman.mean_events, 30U);
  EXPECT_EQ(s.update.contour_mask, 0U);
  EXPECT_EQ(told(0), 20U);
  EXPECT_EQ(told(0.5), 60U);
  EXPECT_EQ(s.update.contour_mask, 1U);
}

TEST(Settings, SupportLooksBackForLongerUntilItCannotJudge) {
  Settings s(kConfig);
  s.set_keep(kConfig, 0.5, false);
  EXPECT_EQ(s.support_window_us, 10'000);
  EXPECT_TRUE(s.rejects);
  s.set_keep(kConfig, 0.1, false);
  EXPECT_EQ(s.support_window_us, 50'000);
  EXPECT_FALSE(s.rejects);
  s.set_keep(kConfig, 0, false);
  EXPECT_EQ(s.support_window_us, 50'000);
  s.set_keep(kConfig, 0.5, true);
  EXPECT_FALSE(s.rejects);
  s.set_keep(kConfig, 1, true);
  EXPECT_TRUE(s.rejects);
  EXPECT_EQ(s.support_window_us, 5000);
}

TEST(Settings, AFilterUpstreamMattersWhereEventsWouldBeRejected) {
  for (const double gamma : {0.05, 0.1, 0.15, 0.2, 0.5, 0.74, 0.75, 1.0}) {
    Settings alone(kConfig);
    Settings filtered(kConfig);
    alone.set_keep(kConfig, gamma, false);
    filtered.set_keep(kConfig, gamma, true);
    EXPECT_EQ(alone.rejects, gamma >= 0.15) << gamma;
    EXPECT_EQ(filtered.rejects, gamma >= 0.75) << gamma;
  }
}

TEST(Settings, WhereFewEventsAreKeptFewerMakeACluster) {
  Settings s(kConfig);
  s.set_keep(kConfig, 0.25, false);
  EXPECT_EQ(s.seed_events, 6);
  EXPECT_EQ(s.life.confirm_events, 14);
  EXPECT_EQ(s.life.die_events, 2);
  s.set_keep(kConfig, 0.2, false);
  EXPECT_FLOAT_EQ(s.seed_events, 4.8F);
  EXPECT_FLOAT_EQ(s.life.confirm_events, 11.2F);
  EXPECT_FLOAT_EQ(s.life.die_events, 1.6F);
  s.set_keep(kConfig, 0, false);
  EXPECT_FLOAT_EQ(s.seed_events, 4);
  EXPECT_FLOAT_EQ(s.life.confirm_events, 5.04F);
  s.set_keep(kConfig, 1, false);
  EXPECT_EQ(s.life.confirm_events, 14);
}

TEST(Settings, RejectOnlyIfAsked) {
  ClusterTrackerConfig config = kConfig;
  config.support = asap::ClusterSupport::kEstimate;
  EXPECT_FALSE(Settings(config).rejects);
  EXPECT_TRUE(Settings(config).asks_support);
  config.support = asap::ClusterSupport::kOff;
  EXPECT_FALSE(Settings(config).asks_support);
}

TEST(Settings, BirthsNeedMoreThanNoise) {
  const Settings s(kConfig);
  EXPECT_FLOAT_EQ(s.birth_threshold(0), 6);
  EXPECT_NEAR(s.birth_threshold(1), 2.16 + 4 * 1.4697 + 2, 1e-3);  // 12 x 12 px, 15 ms
}

}  // namespace
}  // namespace settings_test
