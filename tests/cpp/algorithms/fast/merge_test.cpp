#include "algorithms/fast/merge.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace merge_test {
namespace {

using namespace asap::fast;

constexpr MergeRule kRule{.tolerance_px = 4, .rotation_rad = 0.5F};
constexpr PairRule kPairs{.birth_radius_px = 18,
                          .merge_reach = 1.6F,
                          .merge_padding_px = 8,
                          .contact_reach = 1.6F,
                          .contact_padding_px = 1};
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
    tracks.life(slot).confirmed_s = 1;
    tracks.life(slot).extent_px = 5;
    tracks.life(slot).kalman.pvv = 100;
    return slot;
  }
  void polarity(float of_a, float of_b) {
    tracks.contour(a).polarity = of_a;
    tracks.contour(b).polarity = of_b;
  }
  // Time until they are taken for one while `speed` drives them apart, or -1.
  float until_one(float speed_px_s = 0) {
    for (float t = 0; t < 1; t += kTick_s) {
      const float dx = 16 + speed_px_s * t;
      const Candidate pair{a, b, dx, 0, dx};
      if (are_one(tracks, pair, kTick_s, kRule)) return t;
    }
    return -1;
  }
};

TEST(AreOne, TwoTentativeOnesAtOnce) {
  EXPECT_EQ(Two(Phase::kTentative, Phase::kTentative).until_one(), 0);
}

TEST(AreOne, AOneSidedNewbornIsAFragmentSoon) {
  Two two(Phase::kTentative, Phase::kConfirmed);
  two.polarity(1, 0);
  EXPECT_NEAR(two.until_one(), 0.01F, 0.003F);
  Two whole(Phase::kTentative, Phase::kConfirmed);
  EXPECT_NEAR(whole.until_one(), 0.08F, 0.005F);
}

TEST(AreOne, EdgesOfOneObjectSoonerThanWholeObjects) {
  Two edges(Phase::kConfirmed, Phase::kConfirmed);
  edges.polarity(1, -1);
  EXPECT_NEAR(edges.until_one(), 0.15F, 0.005F);  // 15 px
  Two whole(Phase::kConfirmed, Phase::kConfirmed);
  EXPECT_NEAR(whole.until_one(), 0.2F, 0.005F);  // 20 px
}

TEST(AreOne, ThoseThatMetWhenTheyWouldHaveParted) {
  const auto until_one = [](float usual_vx, bool siblings, float age_s = 1) {
    Two two(Phase::kConfirmed, Phase::kConfirmed);
    two.tracks.life(two.a).extent_px = 30;  // they overlap
    two.tracks.life(two.b).confirmed_s = age_s;
    two.tracks.life(two.b).usual_vx = usual_vx;
    if (siblings) find_sibling(two.tracks, two.b, 0, kPairs);
    return two.until_one();
  };
  EXPECT_NEAR(until_one(100, false), 0.1F, 0.003F);
  EXPECT_NEAR(until_one(0, true), 0.03F, 0.003F);
  EXPECT_NEAR(until_one(0, false, 0.09F), 0.03F, 0.003F);
  EXPECT_NEAR(until_one(200, false), 0.05F, 0.003F);
}

TEST(AreOne, ThoseThatMetAndMovedAlikeBeforeAfterLong) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  two.tracks.life(two.a).extent_px = 30;
  two.tracks[two.a].vx = two.tracks[two.b].vx = 30;  // 20 px take longer
  EXPECT_NEAR(two.until_one(), 0.3F, 0.003F);
}

TEST(AreOne, YoungEdgesAtOnce) {
  Two edges(Phase::kConfirmed, Phase::kConfirmed);
  edges.polarity(1, -1);
  edges.tracks.life(edges.b).confirmed_s = 0.01F;
  EXPECT_NEAR(edges.until_one(), 0.015F, 0.004F);
}

TEST(AreOne, ThoseThatComeApartNever) {
  for (const float polarity : {0.0F, 1.0F}) {
    Two two(Phase::kConfirmed, Phase::kConfirmed);
    two.polarity(polarity, -polarity);
    EXPECT_EQ(two.until_one(60), -1);
  }
}

TEST(AreOne, ThoseThatPassRoundEachOtherNever) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  for (float t = 0; t < 1; t += kTick_s) {
    const Candidate pair{two.a, two.b, 16 * std::cos(6 * t), 16 * std::sin(6 * t), 16};
    ASSERT_FALSE(are_one(two.tracks, pair, kTick_s, kRule)) << t;
  }
}

TEST(AreOne, ThoseThatStandStillNotYet) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  two.tracks[two.a].vx = two.tracks[two.b].vx = 0;
  EXPECT_EQ(two.until_one(), -1);
}

TEST(AreOne, VelocitiesThatDifferForbidItUnlessTheyAreSiblings) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  two.tracks[two.b].vx = 200;
  EXPECT_EQ(two.until_one(), -1);
  Two siblings(Phase::kConfirmed, Phase::kConfirmed);
  siblings.tracks[siblings.b].vx = 200;
  find_sibling(siblings.tracks, siblings.b, 0, kPairs);
  ASSERT_TRUE(are_siblings(siblings.tracks, siblings.a, siblings.b));
  EXPECT_NEAR(siblings.until_one(), 0.2F, 0.005F);
}

TEST(AreOne, AnotherPartnerBeginsAnew) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  const auto c = two.add(0, Phase::kConfirmed, 3);
  for (int i = 0; i < 300; ++i) {
    const Candidate pair{two.a, i % 2 == 0 ? two.b : c, 16, 0, 16};
    EXPECT_FALSE(are_one(two.tracks, pair, kTick_s, kRule));
  }
}

TEST(Siblings, AreForgottenOutOfReachAndByGeneration) {
  Two two(Phase::kConfirmed, Phase::kConfirmed);
  find_sibling(two.tracks, two.b, 0, kPairs);
  forget_far_sibling(two.tracks, two.b, 0, kPairs);
  EXPECT_TRUE(are_siblings(two.tracks, two.b, two.a));
  two.tracks[two.b].x = 29;  // 1.6 (5 + 5) + 8 + 4 = 28
  forget_far_sibling(two.tracks, two.b, 0, kPairs);
  EXPECT_FALSE(are_siblings(two.tracks, two.a, two.b));
  two.tracks[two.b].x = 16;
  find_sibling(two.tracks, two.b, 0, kPairs);
  ++two.tracks[two.a].generation;
  EXPECT_FALSE(are_siblings(two.tracks, two.a, two.b));
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
  two.tracks.life(two.a).mass = 100;
  two.tracks.life(two.b).mass = 300;
  two.tracks.life(two.a).events = two.tracks.life(two.b).events = 100;
  two.tracks.life(two.a).fast_rate_hz = two.tracks.life(two.b).fast_rate_hz = 7;
  two.tracks.contour(two.a).count.fill(9);
  merge(two.tracks, two.a, two.b, 10'000);
  EXPECT_FLOAT_EQ(a.x, 0.75F * 17);
  EXPECT_NEAR(a.sxx, 0.25F * 10 + 0.75F * 20 + 0.25F * 0.75F * 17 * 17, 1e-3F);
  EXPECT_FLOAT_EQ(two.tracks.life(two.a).kalman.x, 0.75F * 17);
  EXPECT_EQ(two.tracks.life(two.a).mass, 400);
  EXPECT_EQ(two.tracks.life(two.a).fast_rate_hz, 14);
  EXPECT_EQ(two.tracks.contour(two.a).count[0], 0);
  EXPECT_EQ(a.stamp, 10'000U);
}

TEST(Merge, OfMasslessTracksIsFinite) {
  Two two(Phase::kTentative, Phase::kTentative);
  two.tracks.life(two.a).events = two.tracks.life(two.b).events = 100;
  merge(two.tracks, two.a, two.b, 0);
  EXPECT_FLOAT_EQ(two.tracks[two.a].x, 8);
}

}  // namespace
}  // namespace merge_test
