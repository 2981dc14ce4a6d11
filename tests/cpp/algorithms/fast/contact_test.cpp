#include "algorithms/fast/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace contact_test {
namespace {

using namespace asap::fast;

constexpr ContourRule kOutline{.clip_px = 5, .memory = 16, .min_known = 3};
constexpr ContactRule kRule{
    .gain = 0.6F, .variance_floor_px2 = 0.3F, .owner_cost = 0.8F, .mean_gain = 0.35F};
const UpdateRule kUpdate{
    .mean_events = 60, .covariance_events = 300, .contour_mask = 3, .contour = kOutline};
const Reciprocals kReciprocals(300);
const DirectionTable kDirections;

// Two confirmed disks of radius 8 at x = 0 and x = `gap`, which know their outlines and each other.
struct TwoDisks {
  explicit TwoDisks(float gap) {
    for (const float x : {0.0F, gap}) {
      const auto slot = tracks.create(x, 0, 0);
      tracks[slot].phase = Phase::kConfirmed;
      tracks[slot].inverse_circle2 = 1 / 144.0F;
      tracks[slot].qa = tracks[slot].qc = 1;
      Contour& contour = tracks.contour(slot);
      contour.radius.fill(8);
      contour.count.fill(16);
      contour.variance = 0.5F;
    }
    for (const Tracks::Slot slot : {a, b}) {
      tracks[slot].partners = 1;
      tracks.life(slot).partners[0] = slot == a ? b : a;
    }
  }
  Tracks::Slot winner(Tracks::Slot owner, float x) {
    return winner_of(tracks, owner, 0, x, 0, kOutline, kRule, kDirections);
  }
  Tracks tracks{2};
  Tracks::Slot a = 0;
  Tracks::Slot b = 1;
};

TEST(Contact, TheOutlineThatFitsWins) {
  TwoDisks disks(18);
  EXPECT_EQ(disks.winner(disks.b, 8), disks.a);  // on a's outline, 2 px off b's
  EXPECT_EQ(disks.winner(disks.a, 10), disks.b);
  EXPECT_EQ(disks.winner(disks.a, 8), disks.a);
}

TEST(Contact, TheOwnerHasAnAdvantage) {
  TwoDisks disks(18);
  EXPECT_EQ(disks.winner(disks.a, 9), disks.a);  // as far from both
  EXPECT_EQ(disks.winner(disks.b, 9), disks.b);
}

TEST(Contact, OnlyPartnersWithAnIdWhoseGateTakesItCompete) {
  TwoDisks disks(18);
  disks.tracks[disks.a].phase = Phase::kTentative;
  EXPECT_EQ(disks.winner(disks.b, 8), disks.b);
  disks.tracks[disks.a].phase = Phase::kCoasting;
  EXPECT_EQ(disks.winner(disks.b, 8), disks.a);
  disks.tracks[disks.a].inverse_circle2 = 1 / 49.0F;
  EXPECT_EQ(disks.winner(disks.b, 8), disks.b);
}

TEST(Contact, WithoutAnOutlineTheGateDecides) {
  const Contour unknown;
  const Sight s{0, 0, 8, 0};
  EXPECT_FLOAT_EQ(contact_cost(unknown, s, 4.0F / 9, 0, kOutline, kRule), 0);
  EXPECT_FLOAT_EQ(contact_cost(unknown, s, 1, 0, kOutline, kRule), 2);
  EXPECT_FLOAT_EQ(contact_cost(unknown, s, 0, 0, kOutline, kRule), 4);
}

TEST(Contact, CovarianceAndOutlineAreFrozen) {
  TwoDisks disks(18);
  Track& track = disks.tracks[disks.a];
  Contour& contour = disks.tracks.contour(disks.a);
  track.sxx = 30;
  for (int i = 0; i < 8; ++i) {
    take_in_contact(track, contour, sight_of(track, 5, 10, 0), 5, 1, kUpdate, kRule, kReciprocals,
                    kDirections);
  }
  EXPECT_EQ(track.sxx, 30);
  EXPECT_EQ(contour.radius[0], 8);
  EXPECT_EQ(track.events, 8U);
  EXPECT_EQ(track.stamp, 5U);
  EXPECT_GT(track.x, 0.5F);  // two px outside of the outline on the right
  EXPECT_LT(track.x, 2.1F);
}

TEST(Contact, AStepFollowsTheResidualAlone) {
  TwoDisks disks(18);
  Track& track = disks.tracks[disks.a];
  Contour& contour = disks.tracks.contour(disks.a);
  track.events = 1000;
  take_in_contact(track, contour, sight_of(track, 0, 8, 0), 0, 1, kUpdate, kRule, kReciprocals,
                  kDirections);
  EXPECT_EQ(track.x, 0);
  take_in_contact(track, contour, sight_of(track, 0, 0, 0), 0, 1, kUpdate, kRule, kReciprocals,
                  kDirections);
  EXPECT_TRUE(std::isfinite(track.x));
  contour.forget_radius();
  take_in_contact(track, contour, sight_of(track, 0, 6, 0), 0, 1, kUpdate, kRule, kReciprocals,
                  kDirections);
  EXPECT_NEAR(track.x, 0.35F * 6 / 60, 1e-5F);
}

}  // namespace
}  // namespace contact_test
