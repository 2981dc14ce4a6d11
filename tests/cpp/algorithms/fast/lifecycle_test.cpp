#include "algorithms/fast/lifecycle.hpp"

#include <gtest/gtest.h>

#include "algorithms/fast/gate_rule.hpp"

namespace lifecycle_test {
namespace {

using namespace asap::fast;

constexpr LifeRule kRule{.mass_s = 0.03F,
                         .confirm_events = 14,
                         .die_events = 2,
                         .die_sigma = 2,
                         .birth_rate_hz = 300,
                         .confirm_evidence = 8,
                         .drop_evidence = 4,
                         .starve_ratio = 0.15F,
                         .velocity_decay_s = 0.1F,
                         .hide_s = 0.06F,
                         .coast_s = 0.2F,
                         .mature_s = 0.04F};

struct Object {
  Track track{};
  Life life{};
  float now_s = 0;

  Object() {
    track.phase = Phase::kTentative;
    life.near_confirmed = false;
  }

  // One tick with so many events.
  Fate tick(std::uint32_t events, float dt_s = 0.002F, float noise_hz = 0) {
    now_s += dt_s;
    const auto now = static_cast<Stamp>(1e6F * now_s);
    track.events += events;
    if (events > 0) track.stamp = now;
    const Fate fate = live(track, life, Tick(now, dt_s, noise_hz, kRule), kRule, kGate);
    if (fate == Fate::kConfirmed) track.phase = Phase::kConfirmed;
    return fate;
  }
  // How long until that fate, s, or -1.
  float until(Fate fate, std::uint32_t events, float limit_s, float noise_hz = 0) {
    for (float t = 0.002F; t < limit_s; t += 0.002F) {
      if (tick(events, 0.002F, noise_hz) == fate) return t;
    }
    return -1;
  }
};

TEST(Lifecycle, ConfirmsWhatHasEnoughEvents) {
  Object busy;
  EXPECT_NEAR(busy.until(Fate::kConfirmed, 10, 0.1F), 0.004F, 1e-3F);
  EXPECT_EQ(busy.track.phase, Phase::kConfirmed);
  Object quiet;
  EXPECT_EQ(quiet.until(Fate::kConfirmed, 0, 0.5F), -1);
}

TEST(Lifecycle, ATentativeOneDiesInTime) {
  Object quiet;
  quiet.tick(5);
  // 5 ln 51 of evidence, less 300 a second, falls to -4.
  EXPECT_NEAR(quiet.until(Fate::kDies, 0, 1), 0.079F, 0.005F);
}

TEST(Lifecycle, NoiseRaisesTheBar) {
  // 10 Hz on the thousand pixels of a newborn's gate: 300 events in 30 ms would be noise.
  Object object;
  EXPECT_EQ(object.until(Fate::kConfirmed, 18, 0.14F, 10), -1);
  Object brighter;
  EXPECT_GT(brighter.until(Fate::kConfirmed, 60, 0.14F, 10), 0);
}

TEST(Lifecycle, ANewbornBesideAConfirmedOneWaits) {
  Object object;
  object.life.near_confirmed = true;
  EXPECT_NEAR(object.until(Fate::kConfirmed, 10, 0.1F), 0.03F, 0.0035F);
}

TEST(Lifecycle, WhatMayBeAFragmentWaitsForAsLongAsItMay) {
  Object object;
  object.life.may_be_fragment = true;
  EXPECT_EQ(object.until(Fate::kConfirmed, 10, 0.1F), -1);
  object.life.may_be_fragment = false;
  EXPECT_EQ(object.tick(10), Fate::kConfirmed);
}

TEST(Lifecycle, AnObjectThatStopsIsHiddenThenCoastsThenDies) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  ASSERT_TRUE(is_listed(object.track, object.life, kRule));
  float hidden = 0;
  float coasting = 0;
  float dead = 0;
  for (float t = 0.002F; t < 1 && dead == 0; t += 0.002F) {
    const Fate fate = object.tick(0);
    if (hidden == 0 && !is_listed(object.track, object.life, kRule)) hidden = t;
    if (coasting == 0 && object.track.phase == Phase::kCoasting) coasting = t;
    if (fate == Fate::kDies) dead = t;
  }
  EXPECT_NEAR(hidden, 0.016F + 0.06F, 0.01F);  // starved once the fast rate is below 15 %
  EXPECT_NEAR(coasting, 0.03F * 5, 0.01F);     // a mass of 300 falls to 2
  EXPECT_NEAR(dead, coasting + 0.2F, 0.005F);
}

TEST(Lifecycle, ACoastingOneComesBack) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  for (int i = 0; i < 100; ++i) object.tick(0);
  ASSERT_EQ(object.track.phase, Phase::kCoasting);
  object.tick(20);
  EXPECT_EQ(object.track.phase, Phase::kConfirmed);
  EXPECT_TRUE(is_listed(object.track, object.life, kRule));
}

TEST(Lifecycle, OneLateTickIsAsManyTicks) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  Object survivor = object;
  EXPECT_EQ(survivor.tick(0, 0.3F), Fate::kLives);
  EXPECT_EQ(survivor.track.phase, Phase::kCoasting);
  EXPECT_FALSE(is_listed(survivor.track, survivor.life, kRule));
  EXPECT_EQ(object.tick(0, 0.45F), Fate::kDies);
}

TEST(Lifecycle, TheSlowRateIsFrozenWhileStarved) {
  Object object;
  for (int i = 0; i < 200; ++i) object.tick(20);
  const float usual = object.life.slow_rate_hz;
  EXPECT_NEAR(usual, 10'000, 200);
  for (int i = 0; i < 50; ++i) object.tick(0);
  EXPECT_GT(object.life.slow_rate_hz, 0.7F * usual);
  EXPECT_TRUE(is_starved(object.life));
  object.tick(20);
  object.tick(20);
  EXPECT_FALSE(is_starved(object.life));
}

TEST(Lifecycle, WhatIsLetDieDies) {
  Object object;
  for (int i = 0; i < 100; ++i) object.tick(20);
  let_die(object.track, object.life);
  EXPECT_FALSE(is_listed(object.track, object.life, kRule));
  EXPECT_EQ(object.tick(20), Fate::kDies);
}

TEST(Lifecycle, RemembersTheLastEvent) {
  Object object;
  object.tick(20);
  object.tick(0);
  EXPECT_EQ(object.life.last_event, 2000U);
}

TEST(Lifecycle, TheUsualExtentIsTheMeanAtFirst) {
  Life life;
  life.age_s = 0.002F;
  const Tick tick(0, 0.002F, 0, kRule);
  remember_extent(life, 40, tick);
  EXPECT_FLOAT_EQ(life.usual_extent2, 40);
  life.age_s = 0.008F;
  remember_extent(life, 60, tick);
  EXPECT_FLOAT_EQ(life.usual_extent2, 45);
}

}  // namespace
}  // namespace lifecycle_test
