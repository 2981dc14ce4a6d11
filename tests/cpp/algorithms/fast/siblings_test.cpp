#include "algorithms/fast/siblings.hpp"

#include <gtest/gtest.h>

#include "algorithms/fast/pair_rule.hpp"

namespace asap::fast::siblings_test {
namespace {

// Confirmed tracks in a row, with extents of 5 px: two are in reach within 24 px.
struct Row {
  Tracks tracks{8};
  Tracks::Slot a = add(0);
  Tracks::Slot b = add(16);

  Tracks::Slot add(float x, Phase phase = Phase::kConfirmed) {
    const auto slot = tracks.create(x, 0, 0);
    tracks[slot].phase = phase;
    tracks.state(slot).extent_px = 5;
    return slot;
  }
  void find(Tracks::Slot slot) { find_sibling(tracks, slot, 0, kPairs); }
  bool siblings(Tracks::Slot one, Tracks::Slot other) const {
    const bool found = are_siblings(tracks, one, other);
    EXPECT_EQ(found, are_siblings(tracks, other, one));
    return found;
  }
};

TEST(Siblings, AreATrackAndTheNearestConfirmedOne) {
  Row row;
  const auto c = row.add(28);
  const auto tentative = row.add(29, Phase::kTentative);
  row.find(c);
  EXPECT_TRUE(row.siblings(c, row.b));
  EXPECT_FALSE(row.siblings(c, row.a));
  EXPECT_FALSE(row.siblings(c, tentative));
}

TEST(Siblings, AreInReach) {
  Row row;
  const auto far = row.add(41);
  row.find(far);
  EXPECT_FALSE(row.siblings(far, row.b));
  row.tracks[far].x = 39;
  row.find(far);
  EXPECT_TRUE(row.siblings(far, row.b));
}

TEST(Siblings, AreForgottenOutOfReachAndByGeneration) {
  Row row;
  row.find(row.b);
  row.tracks[row.b].x = 27;  // 24 and a margin of 4
  forget_far_sibling(row.tracks, row.b, 0, kPairs);
  EXPECT_TRUE(row.siblings(row.b, row.a));
  row.tracks[row.b].x = 29;
  forget_far_sibling(row.tracks, row.b, 0, kPairs);
  EXPECT_FALSE(row.siblings(row.a, row.b));
  row.tracks[row.b].x = 16;
  row.find(row.b);
  ++row.tracks[row.a].generation;
  EXPECT_FALSE(row.siblings(row.a, row.b));
}

TEST(Siblings, PassToTheTrackThatTheirsBecomesPartOf) {
  Row row;
  const auto c = row.add(20);
  row.find(c);
  ASSERT_TRUE(row.siblings(c, row.b));
  row.find(row.a);
  ASSERT_TRUE(row.siblings(row.a, row.b));
  ASSERT_FALSE(row.siblings(c, row.a));
  merge(row.tracks, row.a, row.b, 0);
  row.tracks.remove(row.b);
  EXPECT_TRUE(row.siblings(c, row.a));
  EXPECT_EQ(row.tracks.state(row.a).sibling, kNoSlot);
}

}  // namespace
}  // namespace asap::fast::siblings_test
