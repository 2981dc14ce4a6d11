#include "study/owner_cell_merge.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

namespace asap::owner_cell_merge_test {
namespace {

constexpr auto kNone = fast::Tracks::kNone;

class OwnerCellMergeTest : public testing::Test {
 protected:
  using Slot = OwnerCellMerge::Slot;

  Slot tentative(float x, float y, float mass = 10) {
    const Slot slot = tracks.create(x, y, 0);
    tracks.state(slot).mass = mass;
    return slot;
  }

  Slot confirmed(float x, float y, float vx = 0, float vy = 0) {
    const Slot slot = tentative(x, y);
    tracks[slot].phase = fast::Phase::kConfirmed;
    tracks[slot].id = next_id++;
    tracks[slot].vx = vx;
    tracks[slot].vy = vy;
    return slot;
  }

  // What is joined after so many ticks.
  Slot after(int ticks) {
    for (int tick = 0; tick < ticks; ++tick) merge.hold(tracks);
    return merge.join_confirmed(tracks, owners);
  }

  fast::CellMap map{100, 100, 4};
  fast::OwnerGrid owners{map};
  fast::Tracks tracks{8};
  OwnerCellMerge merge{map, 8, 20};
  std::int32_t next_id = 0;
};

TEST_F(OwnerCellMergeTest, ATentativeOneJoinsTheNearestAtOnce) {
  const Slot young = tentative(50, 50);
  confirmed(62, 50, 500);  // whatever its velocity
  const Slot nearest = confirmed(50, 60, 500);
  EXPECT_EQ(merge.join_tentative(tracks, owners), young);
  EXPECT_FLOAT_EQ(tracks[nearest].y, 55);
  EXPECT_EQ(tracks.state(nearest).mass, 20);
}

TEST_F(OwnerCellMergeTest, ReachesTheRootOfEightTenthsOfTheRadius) {
  const Slot young = tentative(50, 50);
  const Slot other = confirmed(50, 67.95F);  // 17.89 px
  EXPECT_EQ(merge.join_tentative(tracks, owners), kNone);
  tracks[other].y = 67.85F;
  EXPECT_EQ(merge.join_tentative(tracks, owners), young);
}

TEST_F(OwnerCellMergeTest, MomentsAreThoseOfTheUnion) {
  const Slot one = confirmed(40, 50);
  const Slot two = tentative(50, 54, 30);  // three quarters of the mass
  tracks[one].sxx = 8;
  tracks[one].syy = 4;
  tracks[two].sxx = 16;
  tracks[two].sxy = 2;
  EXPECT_EQ(merge.join_tentative(tracks, owners), two);
  EXPECT_FLOAT_EQ(tracks[one].x, 47.5F);
  EXPECT_FLOAT_EQ(tracks[one].y, 53);
  EXPECT_FLOAT_EQ(tracks[one].sxx, 2 + 12 + 0.1875F * 100);
  EXPECT_FLOAT_EQ(tracks[one].sxy, 1.5F + 0.1875F * 40);
  EXPECT_FLOAT_EQ(tracks[one].syy, 1 + 0.1875F * 16);
}

TEST_F(OwnerCellMergeTest, TheCellsOfTheOneThatGoesAreTheOthers) {
  const Slot one = confirmed(40, 50);
  const Slot two = tentative(50, 54);
  const auto slot = static_cast<std::uint8_t>(two);
  owners[30] = {7, tracks[two].generation, slot};
  owners[31] = {7, static_cast<std::uint16_t>(tracks[two].generation - 1), slot};
  merge.join_tentative(tracks, owners);
  EXPECT_EQ(owners[30].slot, one);
  EXPECT_EQ(owners[30].generation, tracks[one].generation);
  EXPECT_EQ(owners[30].stamp, 7u);
  EXPECT_EQ(owners[31].slot, two);
}

TEST_F(OwnerCellMergeTest, TwoConfirmedOnesJoinAfterTenTicksIntoTheOlder) {
  confirmed(50, 50);
  const Slot younger = confirmed(50, 60);
  EXPECT_EQ(merge.join_tentative(tracks, owners), kNone);
  EXPECT_EQ(after(9), kNone);
  EXPECT_EQ(after(1), younger);
}

TEST_F(OwnerCellMergeTest, ATickApartBeginsTheCountAnew) {
  confirmed(50, 50);
  const Slot younger = confirmed(50, 60);
  EXPECT_EQ(after(9), kNone);
  tracks[younger].y = 90;
  EXPECT_EQ(after(1), kNone);
  tracks[younger].y = 60;
  EXPECT_EQ(after(9), kNone);
  EXPECT_EQ(after(1), younger);
}

TEST_F(OwnerCellMergeTest, AnotherPartnerBeginsTheCountAnew) {
  confirmed(50, 50);
  const Slot first = confirmed(50, 60);
  EXPECT_EQ(after(9), kNone);
  tracks.remove(first);
  const Slot second = confirmed(50, 61);
  EXPECT_EQ(first, second);  // of another generation
  merge.forget(second);
  EXPECT_EQ(after(1), kNone);
}

TEST_F(OwnerCellMergeTest, OnlyWithSimilarVelocities) {
  const Slot one = confirmed(50, 50, 100, 0);
  const Slot two = confirmed(50, 60, 0, 0);
  EXPECT_EQ(after(20), kNone);  // 100 against 50 + 25
  tracks[two].vx = 35;
  EXPECT_EQ(after(10), two);  // 65 against 67.5 + 25
  tracks[one].vx = tracks[two].vx = 0;
  tracks[two].vx = 60;
  EXPECT_EQ(after(1), kNone);  // 60 against 30 + 25
}

}  // namespace
}  // namespace asap::owner_cell_merge_test
