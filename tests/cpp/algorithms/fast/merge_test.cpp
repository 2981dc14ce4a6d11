#include "algorithms/fast/merge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "algorithms/fast/gate.hpp"
#include "algorithms/fast/pair_rule.hpp"
#include "algorithms/fast/siblings.hpp"

namespace asap::fast::merge_test {
namespace {

// ---- pairs ----

struct Scene {
  Tracks tracks{8};
  Pairs pairs{8};

  Tracks::Slot add(float x, float y, bool confirmed, float variance = 25) {
    const auto slot = tracks.create(x, y, 0);
    tracks[slot].phase = confirmed ? Phase::kConfirmed : Phase::kTentative;
    tracks[slot].sxx = tracks[slot].syy = variance;
    tracks.state(slot).extent_px = std::sqrt(variance);
    return slot;
  }
  const std::vector<Candidate>& find(Stamp now = 0) {
    pairs.find(tracks, now, kPairs);
    return pairs.candidates();
  }
};

TEST(MergeDistance, GrowsWithTheExtents) {
  EXPECT_FLOAT_EQ(merge_distance(0, kPairs), 0.9F * 18);
  EXPECT_FLOAT_EQ(merge_distance(20, kPairs), 40);
}

TEST(Pairs, ConfirmedTracksThatNearlyMeetAreInContact) {
  Scene scene;
  const auto a = scene.add(0, 0, true);
  const auto b = scene.add(16, 0, true);  // 1.6 (5 + 5) + 1 = 17
  const auto c = scene.add(-18, 0, true);
  scene.find();
  EXPECT_EQ(scene.tracks[a].partners, 1);
  EXPECT_EQ(scene.tracks.state(a).partners[0], b);
  EXPECT_EQ(scene.tracks.state(b).partners[0], a);
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

TEST(Pairs, TheTentativeTrackKeepsTheMixedPair) {
  Scene scene;
  const auto confirmed = scene.add(0, 0, true);
  const auto tentative = scene.add(20, 3, false);
  ASSERT_EQ(scene.find().size(), 1U);
  const Candidate& pair = scene.pairs.candidates()[0];
  EXPECT_EQ(pair.keeper, tentative);
  EXPECT_EQ(pair.other, confirmed);
  EXPECT_FLOAT_EQ(pair.dx, -20);
  EXPECT_FLOAT_EQ(pair.dy, -3);
  EXPECT_TRUE(scene.tracks.state(tentative).near_confirmed);
  EXPECT_FALSE(scene.tracks.state(confirmed).near_confirmed);
  EXPECT_EQ(scene.tracks[confirmed].partners, 0);
}

TEST(Pairs, ConfirmedTracksWithin35PxAreNear) {
  Scene scene;
  const auto a = scene.add(0, 0, true, 100);
  const auto b = scene.add(34, 0, true, 100);
  const auto c = scene.add(70, 0, true, 100);  // in reach of b: 1.6 (10 + 10) + 8 + 8 = 48
  scene.find();
  EXPECT_TRUE(scene.tracks.state(a).near_confirmed);
  EXPECT_TRUE(scene.tracks.state(b).near_confirmed);
  EXPECT_FALSE(scene.tracks.state(c).near_confirmed);
}

TEST(Pairs, TentativeTracksAreFoundAtTheTipsOfALargeMatureOne) {
  const auto finds = [](float distance, float variance, float age_s) {
    Scene scene;  // the tentative one is the first or the last
    const auto before = scene.add(-distance, 0, false);
    const auto confirmed = scene.add(0, 0, true, variance);
    const auto after = scene.add(distance, 0, false);
    scene.tracks.state(confirmed).age_s = age_s;
    const std::size_t found = scene.find().size();
    EXPECT_EQ(scene.tracks.state(before).near_confirmed, found > 0);
    EXPECT_EQ(scene.tracks.state(after).near_confirmed, found > 0);
    return found;
  };
  EXPECT_EQ(finds(70, 400, 0.06F), 2);  // 2.5 (20 + 5) + 8
  EXPECT_EQ(finds(71, 400, 0.06F), 0);
  EXPECT_EQ(finds(49, 400, 0.04F), 0);  // young: 1.6 (20 + 5) + 8
  EXPECT_EQ(finds(30, 64, 0.06F), 0);   // small: 1.6 (8 + 5) + 8
}

TEST(Pairs, ATentativeTrackOnAMatureOneMayBeItsFragment) {
  Scene scene;
  const auto mature = scene.add(0, 0, true);
  const auto tentative = scene.add(10, 0, false);
  scene.tracks[mature].inverse_circle2 = 1e-2F;           // a gate of 10 px ...
  scene.tracks[mature].qa = scene.tracks[mature].qc = 1;  // ... and a small ellipse
  scene.tracks.state(mature).mass = 100;
  scene.tracks.state(mature).age_s = 1;
  scene.find();
  EXPECT_TRUE(scene.tracks.state(tentative).may_be_fragment);
  EXPECT_FALSE(scene.tracks.state(mature).may_be_fragment);
  EXPECT_EQ(scene.tracks.state(mature).fragment_s, 0);
  scene.tracks[tentative].x = 20;
  scene.tracks.state(mature).fragment_s = 0.5F;
  scene.find();
  EXPECT_FALSE(scene.tracks.state(tentative).may_be_fragment);
  EXPECT_EQ(scene.tracks.state(mature).fragment_s, 0.5F);
  EXPECT_TRUE(scene.tracks.state(tentative).near_confirmed);
}

TEST(Pairs, ALargeTrackKeepsTheFourNearestPairs) {
  Scene scene;
  const auto a = scene.add(0, 0, true, 81);
  for (const float y : {-20.0F, 15.0F, 22.0F, 16.0F, -14.0F, 23.0F}) scene.add(0, y, true);
  const auto& found = scene.find();
  std::vector<float> distances;
  for (const Candidate& pair : found) {
    if (pair.keeper == a) distances.push_back(pair.distance_px);
  }
  EXPECT_EQ(distances, (std::vector<float>{14, 15, 16, 20}));
}

TEST(Pairs, ASmallTrackKeepsTheNearestPair) {
  Scene scene;
  const auto a = scene.add(0, 0, true);
  for (const float y : {-20.0F, 15.0F, 22.0F}) scene.add(0, y, true);
  std::vector<float> distances;
  for (const Candidate& pair : scene.find()) {
    if (pair.keeper == a) distances.push_back(pair.distance_px);
  }
  EXPECT_EQ(distances, std::vector<float>{15});
}

TEST(Pairs, ATentativeTrackKeepsTheNearestPair) {
  Scene scene;
  const auto tentative = scene.add(0, 0, false);
  scene.add(20, 0, true);
  const auto near = scene.add(-14, 0, true);
  std::vector<Candidate> own;
  for (const Candidate& pair : scene.find()) {
    if (pair.keeper == tentative) own.push_back(pair);
  }
  ASSERT_EQ(own.size(), 1U);
  EXPECT_EQ(own[0].other, near);
}

TEST(Pairs, UsePredictedPositionsAndForgetOldPartners) {
  Scene scene;
  const auto a = scene.add(0, 0, true);
  const auto b = scene.add(15, 0, true);
  scene.find();
  EXPECT_EQ(scene.tracks[a].partners, 1);
  scene.tracks[b].vx = 1000;
  EXPECT_TRUE(scene.find(60'000).empty());  // 75 px away by now
  EXPECT_EQ(scene.tracks[a].partners, 0);
}

// ---- fragments ----

constexpr GateRule kGate{.birth_radius_px = 18,
                         .min_radius_px = 7,
                         .max_radius_px = 40,
                         .scale = 2,
                         .padding_px = 0,
                         .circle_scale = 0,
                         .circle_padding_px = 0};

// A mature track whose gate reaches 24 px in x and 16 px in y, and a tentative one.
struct Beside {
  Tracks tracks{4};
  Tracks::Slot mature = add(Phase::kConfirmed, 100);
  Tracks::Slot tentative = add(Phase::kTentative, 19);

  Beside() {
    tracks[mature].sxx = 144;
    tracks[mature].syy = 64;
    tracks.state(mature).age_s = 0.21F;
    shape_gate(tracks[mature], kGate, kGate.scale, 18, 144, true, 0);
  }
  Tracks::Slot add(Phase phase, float mass) {
    const auto slot = tracks.create(0, 0, 0);
    tracks[slot].phase = phase;
    tracks.state(slot).mass = mass;
    return slot;
  }
  void touch(Tracks::Slot other) {
    tracks.state(mature).partners[tracks[mature].partners++] = other;
  }
  bool wait(float dx, float dy) const { return may_be_fragment(tracks, tentative, mature, dx, dy); }
};

TEST(Fragment, LiesInTheWidenedGate) {
  const Beside two;
  EXPECT_TRUE(two.wait(29.9F, 0));  // 1.25 x 24
  EXPECT_FALSE(two.wait(30.1F, 0));
  EXPECT_TRUE(two.wait(0, -19.9F));  // 1.25 x 16
  EXPECT_FALSE(two.wait(0, -20.1F));
}

TEST(Fragment, IsSmallBesideIt) {
  Beside two;
  two.tracks.state(two.tentative).mass = 21;
  EXPECT_FALSE(two.wait(20, 0));
}

TEST(Fragment, IsOfAMatureTrack) {
  Beside two;
  two.tracks.state(two.mature).age_s = 0.049F;
  EXPECT_FALSE(two.wait(20, 0));
}

TEST(Fragment, IsOneInContactToo) {
  Beside two;
  two.touch(two.add(Phase::kConfirmed, 100));
  EXPECT_TRUE(two.wait(20, 0));
}

// ---- merging ----

constexpr MergeRule kRule{.tolerance_px = 4, .rotation_rad = 0.5F};
constexpr float kTick_s = 0.002F;

// Two tracks 16 px apart that move to the right at 100 px/s.
struct Two {
  Tracks tracks{4};
  Tracks::Slot a;
  Tracks::Slot b;

  Two(Phase first, Phase second) : a(add(0, first, 1)), b(add(16, second, 2)) {}

  Tracks::Slot add(float x, Phase phase, std::int32_t id) {
    const auto slot = tracks.create(x, 0, 0);
    Track& track = tracks[slot];
    track.phase = phase;
    track.vx = 100;
    track.events = 100;
    if (track.has_id()) track.id = id;
    tracks.state(slot).confirmed_s = 1;
    tracks.state(slot).extent_px = 5;
    tracks.state(slot).kalman.pvv = 100;
    return slot;
  }
  void polarity(float of_a, float of_b) {
    tracks.contour(a).polarity = of_a;
    tracks.contour(b).polarity = of_b;
  }
  // Time until they are one object while they separate at this speed, or -1.
  float until_one(float speed_px_s = 0) {
    for (float t = 0; t < 1; t += kTick_s) {
      const float dx = 16 + speed_px_s * t;
      const Candidate pair{a, b, dx, 0, dx};
      if (are_one(tracks, pair, kTick_s, kRule)) return t;
    }
    return -1;
  }
};

TEST(AreOne, TwoTentativeTracksAtOnce) {
  EXPECT_EQ(Two(Phase::kTentative, Phase::kTentative).until_one(), 0);
}

TEST(AreOne, ATentativeTrackWithOneEdgeIsAFragmentSoon) {
  Two two(Phase::kTentative, Phase::kConfirmed);
  two.polarity(1, 0);
  EXPECT_NEAR(two.until_one(), 0.01F, 0.003F);
  Two whole(Phase::kTentative, Phase::kConfirmed);
  EXPECT_NEAR(whole.until_one(), 0.08F, 0.005F);
}

TEST(AreOne, SingleEdgesSoonerThanWholeObjects) {
  Two edges(Phase::kConfirmed, Phase::kConfirmed);
  edges.polarity(1, -1);
  EXPECT_NEAR(edges.until_one(), 0.15F, 0.005F);  // 15 px
  Two whole(Phase::kConfirmed, Phase::kConfirmed);
  EXPECT_NEAR(whole.until_one(), 0.2F, 0.005F);  // 20 px
}

TEST(AreOne, TracksThatMetOnceTheyWouldHaveSeparated) {
  const auto until_one = [](float average_vx, bool siblings, float age_s = 1) {
    Two two(Phase::kConfirmed, Phase::kConfirmed);
    two.tracks.state(two.a).extent_px = 30;  // they overlap
    two.tracks.state(two.b).confirmed_s = age_s;
    two.tracks.state(two.b).average_vx = average_vx;
    if (siblings) find_sibling(two.tracks, two.b, 0, kPairs);
    return two.until_one();
  };
  EXPECT_NEAR(until_one(100, false), 0.1F, 0.003F);
  EXPECT_NEAR(until_one(0, true), 0.03F, 0.003F);
  EXPECT_NEAR(until_one(0, false, 0.09F), 0.03F, 0.003F);
  EXPECT_NEAR(until_one(200, false), 0.05F, 0.003F);
}

TEST(AreOne, TracksThatMovedAlikeBeforeAfterLong) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  two.tracks.state(two.a).extent_px = 30;
  two.tracks[two.a].vx = two.tracks[two.b].vx = 30;  // 20 px take longer
  EXPECT_NEAR(two.until_one(), 0.3F, 0.003F);
}

TEST(AreOne, YoungSingleEdgesSoon) {
  Two edges(Phase::kConfirmed, Phase::kConfirmed);
  edges.polarity(1, -1);
  edges.tracks.state(edges.b).confirmed_s = 0.01F;
  EXPECT_NEAR(edges.until_one(), 0.015F, 0.004F);
}

TEST(AreOne, NotTracksThatSeparate) {
  for (const float polarity : {0.0F, 1.0F}) {
    Two two(Phase::kConfirmed, Phase::kConfirmed);
    two.polarity(polarity, -polarity);
    EXPECT_EQ(two.until_one(60), -1);
  }
}

// Tracks 16 px apart wander by 6 px: within .35 of the extents, 18 + 5 and 33 + 5 px.
TEST(AreOne, LargeTracksCloseTogetherMayWander) {
  const auto until_one = [](float extent_px) {
    Two two(Phase::kConfirmed, Phase::kConfirmed);
    two.tracks.state(two.a).extent_px = extent_px;
    two.tracks.state(two.a).average_vx = 1000;
    for (float t = 0; t < 1; t += kTick_s) {
      const float dx = 16 + (static_cast<int>(t / 0.02F) % 2 == 1 ? 6.0F : 0.0F);  // 6 > 4
      const Candidate pair{two.a, two.b, dx, 0, dx};
      if (are_one(two.tracks, pair, kTick_s, kRule)) return t;
    }
    return -1.0F;
  };
  EXPECT_EQ(until_one(12), -1);              // 16 px are more than 1.3 of 12
  EXPECT_NEAR(until_one(18), 0.2F, 0.005F);  // 20 px
  EXPECT_NEAR(until_one(33), 0.04F, 0.02F);  // one lies in the other
}

TEST(AreOne, NotTracksThatCircleEachOther) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  for (float t = 0; t < 1; t += kTick_s) {
    const Candidate pair{two.a, two.b, 16 * std::cos(6 * t), 16 * std::sin(6 * t), 16};
    ASSERT_FALSE(are_one(two.tracks, pair, kTick_s, kRule)) << t;
  }
}

TEST(AreOne, NotWholeTracksAtRest) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  two.tracks[two.a].vx = two.tracks[two.b].vx = 0;
  EXPECT_EQ(two.until_one(), -1);
}

TEST(AreOne, NotWithDifferentVelocitiesUnlessSiblings) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  two.tracks[two.b].vx = 200;
  EXPECT_EQ(two.until_one(), -1);
  Two siblings(Phase::kConfirmed, Phase::kConfirmed);
  siblings.tracks[siblings.b].vx = 200;
  find_sibling(siblings.tracks, siblings.b, 0, kPairs);
  ASSERT_TRUE(are_siblings(siblings.tracks, siblings.a, siblings.b));
  EXPECT_NEAR(siblings.until_one(), 0.2F, 0.005F);
}

TEST(AreOne, LargeSiblingsAfterAShortWay) {
  const auto until_one = [](float extent_px, bool siblings) {
    Two two(Phase::kConfirmed, Phase::kConfirmed);
    two.tracks.state(two.b).extent_px = extent_px;
    if (siblings) find_sibling(two.tracks, two.b, 0, kPairs);
    return two.until_one();
  };
  EXPECT_NEAR(until_one(11, true), 0.05F, 0.005F);  // 5 px
  EXPECT_NEAR(until_one(11, false), 0.2F, 0.005F);  // 20 px
  EXPECT_NEAR(until_one(10, true), 0.2F, 0.005F);
}

TEST(AreOne, AnotherCandidateInBetweenDoesNotRestartTheTime) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  two.tracks[two.add(0, Phase::kConfirmed, 3)].vx = 300;
  const Candidate pair{two.a, two.b, 16, 0, 16};
  float t = 0;
  for (; t < 1 && !are_one(two.tracks, pair, kTick_s, kRule); t += kTick_s) {
    const Candidate passing{two.a, 2, 200 * t, 0, 200 * t};
    EXPECT_FALSE(are_one(two.tracks, passing, kTick_s, kRule));
  }
  EXPECT_NEAR(t, 0.2F, 0.005F);  // 20 px, as without the other
}

TEST(AreOne, ACandidateTooManyRestartsTheTime) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  const auto c = two.add(0, Phase::kConfirmed, 3);
  for (int i = 0; i < 300; ++i) {
    for (std::size_t k = 0; k <= kMaxCandidates; ++k) {
      two.tracks[c].generation = static_cast<std::uint16_t>(k);
      const Candidate pair{two.a, k == 0 ? two.b : c, 16, 0, 16};
      EXPECT_FALSE(are_one(two.tracks, pair, kTick_s, kRule));
    }
  }
}

TEST(AreOne, ThinTracksAsSoonAsSingleEdges) {
  const auto until_one = [](float sxx, float syy) {
    Two two(Phase::kConfirmed, Phase::kConfirmed);
    two.tracks.state(two.b).confirmed_s = 0.3F;
    two.tracks[two.b].sxx = sxx;
    two.tracks[two.b].syy = syy;
    return two.until_one();
  };
  EXPECT_NEAR(until_one(2, 50), 0.05F, 0.005F);  // 5 px
  EXPECT_NEAR(until_one(50, 2), 0.05F, 0.005F);
  EXPECT_NEAR(until_one(9, 50), 0.05F, 0.005F);  // an arc
  EXPECT_NEAR(until_one(10, 50), 0.2F, 0.005F);  // a rectangle of 2 to 1
}

TEST(Survivor, ConfirmedThenSmallerIdThenMoreEvents) {
  const Two mixed(Phase::kTentative, Phase::kCoasting);
  EXPECT_EQ(survivor_of(mixed.tracks, mixed.a, mixed.b), mixed.b);
  Two ids(Phase::kConfirmed, Phase::kConfirmed);
  EXPECT_EQ(survivor_of(ids.tracks, ids.b, ids.a), ids.a);
  Two events(Phase::kTentative, Phase::kTentative);
  events.tracks[events.b].events = 101;
  EXPECT_EQ(survivor_of(events.tracks, events.a, events.b), events.b);
}

TEST(Merge, JoinsMomentsAtPredictedPositions) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  Track& a = two.tracks[two.a];
  Track& b = two.tracks[two.b];
  a.sxx = 10;
  b.sxx = 20;
  a.stamp = 10'000;  // b is at 17 by then
  two.tracks.state(two.a).mass = 100;
  two.tracks.state(two.b).mass = 300;
  two.tracks.state(two.a).events = two.tracks.state(two.b).events = 100;
  two.tracks.state(two.a).fast_rate_hz = two.tracks.state(two.b).fast_rate_hz = 7;
  two.tracks.contour(two.a).count.fill(9);
  merge(two.tracks, two.a, two.b, 10'000);
  EXPECT_FLOAT_EQ(a.x, 0.75F * 17);
  EXPECT_NEAR(a.sxx, 0.25F * 10 + 0.75F * 20 + 0.25F * 0.75F * 17 * 17, 1e-3F);
  EXPECT_FLOAT_EQ(two.tracks.state(two.a).kalman.x, 0.75F * 17);
  EXPECT_EQ(two.tracks.state(two.a).mass, 400);
  EXPECT_EQ(two.tracks.state(two.a).fast_rate_hz, 14);
  EXPECT_EQ(two.tracks.contour(two.a).count[0], 0);
  EXPECT_EQ(a.stamp, 10'000U);
}

TEST(Merge, OfMasslessTracksIsFinite) {
  Two two(Phase::kTentative, Phase::kTentative);
  two.tracks.state(two.a).events = two.tracks.state(two.b).events = 100;
  merge(two.tracks, two.a, two.b, 0);
  EXPECT_FLOAT_EQ(two.tracks[two.a].x, 8);
}

}  // namespace
}  // namespace asap::fast::merge_test
