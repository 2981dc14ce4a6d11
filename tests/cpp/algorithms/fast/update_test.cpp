#include "algorithms/fast/update.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace asap::fast::update_test {
namespace {

const UpdateRule kRule{.mean_events = 60,
                       .covariance_events = 300,
                       .contour_mask = 3,
                       .contour = {.clip_px = 5, .memory = 16, .min_known = 3},
                       .contact_gain = 0.6F,
                       .contact_mean_gain = 0.35F};
const Reciprocals kReciprocals(300);
const DirectionTable kDirections;

void give(Track& track, Contour& contour, float x, float y, float sign = 1, Stamp now = 0) {
  update_mean(track, contour, innovation_of(track, now, x, y), now, sign, kRule, kReciprocals,
              kDirections);
}

TEST(MeanUpdate, BeginsAsThePlainMeanAndCovariance) {
  Track track;
  Contour contour;
  for (const float x : {1.0F, 5.0F, 3.0F, 7.0F}) give(track, contour, x, 2 * x);
  EXPECT_FLOAT_EQ(track.x, 4);
  EXPECT_FLOAT_EQ(track.y, 8);
  EXPECT_FLOAT_EQ(track.sxx, 5);
  EXPECT_FLOAT_EQ(track.sxy, 10);
  EXPECT_FLOAT_EQ(track.syy, 20);
  EXPECT_EQ(track.events, 4U);
}

TEST(MeanUpdate, MovesOnWithTheVelocity) {
  Track track;
  Contour contour;
  track.vx = 1000;
  give(track, contour, 0, 0);
  give(track, contour, 10, 0, 1, 10'000);
  EXPECT_FLOAT_EQ(track.x, 10);
  EXPECT_EQ(track.sxx, 0);
  EXPECT_EQ(track.stamp, 10'000U);
}

TEST(MeanUpdate, FirstEventIsTheMean) {
  Track track;
  Contour contour;
  give(track, contour, 7, 9);
  EXPECT_EQ(track.x, 7);
  EXPECT_EQ(track.y, 9);
  EXPECT_EQ(track.sxx, 0);
}

TEST(MeanUpdate, HasTheMemoryThatTheContourSays) {
  Track track;
  Contour contour;
  contour.mean_events = 10;
  for (int i = 0; i < 100; ++i) give(track, contour, 0, 0);
  give(track, contour, 5, 0);
  EXPECT_FLOAT_EQ(track.x, 0.5F);
}

TEST(MeanMemory, GrowsWithTheObjectUpToTheRule) {
  Track track;
  track.sxx = track.syy = 1;
  EXPECT_EQ(size_memory(track, kRule), 10U);
  track.sxx = 11;
  EXPECT_EQ(size_memory(track, kRule), 18U);
  track.syy = 1000;
  EXPECT_EQ(size_memory(track, kRule), 60U);
  UpdateRule thinned = kRule;
  thinned.mean_events = 7;
  EXPECT_EQ(size_memory(track, thinned), 7U);
  track.sxx = track.syy = 0;
  EXPECT_EQ(size_memory(track, thinned), 7U);
}

TEST(MeanMemory, IsTheLongestInContact) {
  Track track;
  Contour contour;
  contour.mean_events = 12;
  EXPECT_EQ(mean_memory(track, contour, kRule), 12U);
  track.partners = 1;
  EXPECT_EQ(mean_memory(track, contour, kRule), 60U);
}

// A disk of radius 8 whose right half fires ten times as often: the plain mean is drawn there.
TEST(MeanUpdate, AKnownOutlineHoldsTheCentre) {
  const auto centre_with = [](float mean_weight) {
    Track track;
    Contour contour;
    for (int i = 0; i < 16 * 200; ++i) {
      const float angle = 0.3927F * static_cast<float>(i);
      give(track, contour, 8 * std::cos(angle), 8 * std::sin(angle));
    }
    track.mean_weight = mean_weight;
    for (int i = 0; i < 200; ++i) {
      const float angle = 0.3927F * static_cast<float>(i);
      if (std::cos(angle) > 0 || i % 10 == 0)
        give(track, contour, 8 * std::cos(angle), 8 * std::sin(angle));
    }
    return track.x;
  };
  EXPECT_GT(centre_with(1), 3);
  EXPECT_LT(std::abs(centre_with(0.1F)), 2.2F);
}

TEST(MeanUpdate, EventWeightFadesWithTheDistanceFromTheOutline) {
  for (const float side : {-1.0F, 1.0F}) {
    EXPECT_EQ(event_weight(side * 3, 0.1F, 0), 1);
    EXPECT_NEAR(event_weight(side * 4.5F, 0.1F, 0), 0.5, 1e-6);
    EXPECT_EQ(event_weight(side * 6, 0.1F, 0), 0);
    EXPECT_EQ(event_weight(side * 20, 0.1F, 0.25F), 0.25F);
    EXPECT_EQ(event_weight(side * 20, 0.3F, 0), 0);
    EXPECT_EQ(event_weight(side * 20, 0.4F, 0), 0.5F);
    EXPECT_EQ(event_weight(side * 20, 1, 0), 1);
  }
}

TEST(MeanUpdate, FarEventsCountIfNoiseIsRare) {
  EXPECT_EQ(far_weight(0), 1);
  EXPECT_EQ(far_weight(0.1F), 1);
  EXPECT_NEAR(far_weight(0.3F), 0.5, 1e-6);
  EXPECT_EQ(far_weight(0.5F), 0);
  EXPECT_EQ(far_weight(5), 0);
}

// How far one event moves a disk of radius 8 that is known.
float moved_by(float distance, float mean_weight, float noise_hz) {
  UpdateRule rule = kRule;
  rule.far_weight = far_weight(noise_hz);
  Track track;
  Contour contour;
  const auto hit = [&](float x, float y) {
    update_mean(track, contour, innovation_of(track, 0, x, y), 0, 1, rule, kReciprocals,
                kDirections);
  };
  for (int i = 0; i < 16 * 200; ++i) {
    const float angle = 2.4F * static_cast<float>(i);  // no direction is left out
    hit(8 * std::cos(angle), 8 * std::sin(angle));
  }
  track.mean_weight = mean_weight;
  const float before = track.x;
  hit(before + distance, track.y);
  return track.x - before;
}

TEST(MeanUpdate, InNoiseEventsFarFromASharpOutlineMoveNothing) {
  EXPECT_EQ(moved_by(16, 0.1F, 1), 0);
  EXPECT_GT(moved_by(16, 0.1F, 0), 0.05F);
  EXPECT_GT(moved_by(10, 0.1F, 1), 0.05F);
  EXPECT_GT(moved_by(16, 0.6F, 1), 0.05F);
}

TEST(MeanUpdate, WeightIsLowWhereTheOutlineIsSharp) {
  Track track;
  track.sxx = track.syy = 50;
  Contour contour;
  contour.variance = 0.5F;
  EXPECT_NEAR(mean_weight(track, contour, {.least = 0.01F, .scale = 1}), 1 / 51.5, 1e-4);
  EXPECT_FLOAT_EQ(mean_weight(track, contour, {.least = 0.1F, .scale = 1}), 0.1F);
  contour.variance = 1e6F;
  EXPECT_NEAR(mean_weight(track, contour, {.least = 0.1F, .scale = 1}), 1, 1e-4);
}

TEST(MeanUpdate, PolarityIsTheMeanSign) {
  Track track;
  Contour contour;
  for (int i = 0; i < 40; ++i) give(track, contour, 0, 0, i % 4 == 0 ? -1.0F : 1.0F);
  EXPECT_NEAR(contour.polarity, 0.5, 1e-4);
}

TEST(MeanUpdate, TheContourLearnsEveryFourthEvent) {
  Track track;
  Contour contour;
  for (int i = 0; i < 7; ++i) give(track, contour, 0, 0);
  int learned = 0;
  for (const auto count : contour.count) learned += count;
  EXPECT_EQ(learned, 1);
}

// ---- contact ----

// A disk of radius 8 around the origin, whose outline is known.
struct Disk {
  Track track;
  Contour contour;

  Disk() {
    contour.radius.fill(8);
    contour.count.fill(16);
    contour.variance = 0.5F;
  }
  void take(float x, Stamp now = 0) {
    update_in_contact(track, contour, innovation_of(track, now, x, 0), now, 1, kRule, kReciprocals,
                      kDirections);
  }
};

TEST(Contact, CovarianceAndOutlineAreFrozen) {
  Disk disk;
  disk.track.sxx = 30;
  for (int i = 0; i < 8; ++i) disk.take(10, 5);
  EXPECT_EQ(disk.track.sxx, 30);
  EXPECT_EQ(disk.contour.radius[0], 8);
  EXPECT_EQ(disk.track.events, 8U);
  EXPECT_EQ(disk.track.stamp, 5U);
  EXPECT_GT(disk.track.x, 0.5F);  // the events are 2 px outside of the outline on the right
  EXPECT_LT(disk.track.x, 2.1F);
}

TEST(Contact, AStepFollowsTheResidualAlone) {
  Disk disk;
  disk.track.events = 1000;
  disk.take(8);
  EXPECT_EQ(disk.track.x, 0);
  disk.take(0);
  EXPECT_TRUE(std::isfinite(disk.track.x));
  disk.contour.forget_radius();
  disk.take(6);
  EXPECT_NEAR(disk.track.x, 0.35F * 6 / 60, 1e-5F);
}

}  // namespace
}  // namespace asap::fast::update_test
