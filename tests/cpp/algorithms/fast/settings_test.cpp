#include "algorithms/fast/settings.hpp"

#include <gtest/gtest.h>

namespace asap::fast::settings_test {
namespace {

constexpr ClusterTrackerConfig kConfig{.width = 346, .height = 260};

TEST(Settings, AreTheConfigurationInOtherUnits) {
  const Settings s(kConfig);
  EXPECT_EQ(s.tick_us, 1000);
  EXPECT_EQ(s.link_us, 40'000);
  EXPECT_EQ(s.support_window_us, 5000);
  EXPECT_FLOAT_EQ(s.lifecycle.mass_s, 0.03F);
  EXPECT_FLOAT_EQ(s.lifecycle.coast_s, 0.25F);
  EXPECT_EQ(s.update.mean_events, 60U);
  EXPECT_EQ(s.update.contour_mask, 3U);
  EXPECT_TRUE(s.rejects_unsupported);
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

TEST(Settings, TheSupportWindowGrowsUntilNothingIsRejected) {
  Settings s(kConfig);
  s.set_keep(kConfig, 0.5, false);
  EXPECT_EQ(s.support_window_us, 10'000);
  EXPECT_TRUE(s.rejects_unsupported);
  s.set_keep(kConfig, 0.1, false);
  EXPECT_EQ(s.support_window_us, 50'000);
  EXPECT_FALSE(s.rejects_unsupported);
  s.set_keep(kConfig, 0, false);
  EXPECT_EQ(s.support_window_us, 50'000);
  s.set_keep(kConfig, 0.5, true);
  EXPECT_FALSE(s.rejects_unsupported);
  s.set_keep(kConfig, 1, true);
  EXPECT_TRUE(s.rejects_unsupported);
  EXPECT_EQ(s.support_window_us, 5000);
}

TEST(Settings, AFilterUpstreamEndsRejectionEarlier) {
  for (const double gamma : {0.05, 0.1, 0.15, 0.2, 0.5, 0.74, 0.75, 1.0}) {
    Settings alone(kConfig);
    Settings filtered(kConfig);
    alone.set_keep(kConfig, gamma, false);
    filtered.set_keep(kConfig, gamma, true);
    EXPECT_EQ(alone.rejects_unsupported, gamma >= 0.15) << gamma;
    EXPECT_EQ(filtered.rejects_unsupported, gamma >= 0.75) << gamma;
  }
}

TEST(Settings, FewerEventsMakeAClusterIfFewAreKept) {
  Settings s(kConfig);
  s.set_keep(kConfig, 0.25, false);
  EXPECT_EQ(s.seed_events, 6);
  EXPECT_EQ(s.lifecycle.confirm_events, 14);
  EXPECT_EQ(s.lifecycle.die_events, 2);
  s.set_keep(kConfig, 0.2, false);
  EXPECT_FLOAT_EQ(s.seed_events, 4.8F);
  EXPECT_FLOAT_EQ(s.gate.noise_events, 6);
  EXPECT_FLOAT_EQ(s.gate.least_density_hz, 0.2F);
  EXPECT_FLOAT_EQ(s.lifecycle.confirm_events, 11.2F);
  EXPECT_FLOAT_EQ(s.lifecycle.die_events, 1.6F);
  s.set_keep(kConfig, 0, false);
  EXPECT_FLOAT_EQ(s.seed_events, 4);
  EXPECT_FLOAT_EQ(s.lifecycle.confirm_events, 5.04F);
  s.set_keep(kConfig, 1, false);
  EXPECT_EQ(s.lifecycle.confirm_events, 14);
  EXPECT_EQ(s.gate.noise_events, 30);
  EXPECT_EQ(s.gate.least_density_hz, 1);
}

TEST(Settings, RejectOnlyIfAsked) {
  ClusterTrackerConfig config = kConfig;
  config.support = ClusterSupport::kEstimate;
  EXPECT_FALSE(Settings(config).rejects_unsupported);
  EXPECT_TRUE(Settings(config).uses_support);
  config.support = ClusterSupport::kOff;
  EXPECT_FALSE(Settings(config).uses_support);
}

TEST(Settings, BirthsNeedMoreThanNoise) {
  const Settings s(kConfig);
  EXPECT_FLOAT_EQ(s.birth_threshold(0), 6);
  EXPECT_NEAR(s.birth_threshold(1), 2.16 + 4 * 1.4697 + 2, 1e-3);  // 12 x 12 px, 15 ms
}

}  // namespace
}  // namespace asap::fast::settings_test
