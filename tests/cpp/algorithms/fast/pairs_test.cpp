#include "algorithms/fast/pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace pairs_test {
namespace {

using namespace asap::fast;

constexpr PairRule kRule{.birth_radius_px = 18,
                         .merge_reach = 1.6F,
                         .merge_padding_px = 8,
                         .contact_reach = 1.6F,
                         .contact_padding_px = 1};

struct Scene {
  Tracks tracks{8};
  Pairs pairs{8};

  Tracks::Slot add(float x, float y, bool confirmed, float variance = 25) {
    const auto slot = tracks.create(x, y, 0);
    tracks[slot].phase = confirmed ? Phase::kConfirmed : Phase::kTentative;
    tracks[slot].sxx = tracks[slot].syy = variance;
    tracks.life(slot).extent_px = std::sqrt(variance);
    return slot;
  }
  const std::vector<Candidate>& find(Stamp now = 0) {
    pairs.find(tracks, now, kRule);
    return pairs.candidates();
  }
};

TEST(MergeDistance, GrowsWithTheExtents) {
  EXPECT_FLOAT_EQ(merge_distance(0, kRule), 0.9F * 18);
  EXPECT_FLOAT_EQ(merge_distance(20, kRule), 40);
}

TEST(Pairs, ConfirmedOnesThatNearlyMeetAreInContact) {
  Scene scene;
  const auto a = scene.add(0, 0, true);
  const auto b = scene.add(16, 0, true);  // 1.6 (5 + 5) + 1 = 17
  const auto c = scene.add(-18, 0, true);
  scene.find();
  EXPECT_EQ(scene.tracks[a].partners, 1);
  EXPECT_EQ(scene.tracks.life(a).partners[0], b);
  EXPECT_EQ(scene.tracks.life(b).partners[0], a);
  EXPECT_EQ(scene.tracks[c].partners, 0);
}

TEST(Pairs, ContactLooksAlongTheLineOfCentres) {
  Scene scene;
  const auto a = scene.add(0, 0, true);
  const auto b = scene.add(0, 16, true);
  scene.tracks[a].syy = scene.tracks[b].syy = 4;  // flat: 1.6 (2 + 2) + 1 = 7.4
  scene.find();
  EXPECT_EQ(scene.tracks[a].partners, 0);
}

TEST(Pairs, HaveAtMostThreePartners) {
  Scene scene;
  for (int i = 0; i < 5; ++i) scene.add(static_cast<float>(i), 0, true);
  scene.find();
  for (const auto slot : scene.tracks.active()) EXPECT_EQ(scene.tracks[slot].partners, 3);
}

TEST(Pairs, ATentativeOneKeepsTheMixedPairAndKnowsIt) {
  Scene scene;
  const auto confirmed = scene.add(0, 0, true);
  const auto tentative = scene.add(20, 3, false);
  ASSERT_EQ(scene.find().size(), 1U);
  const Candidate& pair = scene.pairs.candidates()[0];
  EXPECT_EQ(pair.keeper, tentative);
  EXPECT_EQ(pair.other, confirmed);
  EXPECT_FLOAT_EQ(pair.dx, -20);
  EXPECT_FLOAT_EQ(pair.dy, -3);
  EXPECT_TRUE(scene.tracks.life(tentative).near_confirmed);
  EXPECT_FALSE(scene.tracks.life(confirmed).near_confirmed);
  EXPECT_EQ(scene.tracks[confirmed].partners, 0);
}

TEST(Pairs, ConfirmedOnesKnowWhoIsClose) {
  Scene scene;
  const auto a = scene.add(0, 0, true, 100);
  const auto b = scene.add(34, 0, true, 100);
  const auto c = scene.add(70, 0, true, 100);  // in reach of b: 1.6 (10 + 10) + 8 + 8 = 48
  scene.find();
  EXPECT_TRUE(scene.tracks.life(a).near_confirmed);
  EXPECT_TRUE(scene.tracks.life(b).near_confirmed);
  EXPECT_FALSE(scene.tracks.life(c).near_confirmed);
}

TEST(Pairs, ANewbornOnAGrownOneMayBeItsFragment) {
  Scene scene;
  const auto grown = scene.add(0, 0, true);
  const auto newborn = scene.add(10, 0, false);
  scene.tracks[grown].inverse_circle2 = 1e-2F;          // a gate of 10 px ...
  scene.tracks[grown].qa = scene.tracks[grown].qc = 1;  // ... without an ellipse to speak of
  scene.tracks.life(grown).mass = 100;
  scene.tracks.life(grown).age_s = 1;
  scene.find();
  EXPECT_TRUE(scene.tracks.life(newborn).may_be_fragment);
  EXPECT_FALSE(scene.tracks.life(grown).may_be_fragment);
  scene.tracks[newborn].x = 20;
  scene.find();
  EXPECT_FALSE(scene.tracks.life(newborn).may_be_fragment);
  EXPECT_TRUE(scene.tracks.life(newborn).near_confirmed);
}

TEST(Pairs, TheOlderKeepsTheNearestOfItsLike) {
  Scene scene;
  const auto a = scene.add(0, 0, true);
  scene.add(20, 0, true);
  const auto c = scene.add(0, 15, true);
  const auto& found = scene.find();
  ASSERT_GE(found.size(), 1U);
  EXPECT_EQ(found[0].keeper, a);
  EXPECT_EQ(found[0].other, c);
  EXPECT_FLOAT_EQ(found[0].distance_px, 15);
}

TEST(Pairs, LookAtPredictedPositionsAndForgetOldOnes) {
  Scene scene;
  const auto a = scene.add(0, 0, true);
  const auto b = scene.add(15, 0, true);
  scene.find();
  EXPECT_EQ(scene.tracks[a].partners, 1);
  scene.tracks[b].vx = 1000;
  EXPECT_TRUE(scene.find(60'000).empty());  // 75 px away by now
  EXPECT_EQ(scene.tracks[a].partners, 0);
}

}  // namespace
}  // namespace pairs_test
