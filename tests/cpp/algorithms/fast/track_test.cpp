#include "algorithms/fast/track.hpp"

#include <gtest/gtest.h>

namespace track_test {
namespace {

using asap::fast::Phase;
using asap::fast::Tracks;

TEST(Tracks, BeginTentativeWhereTheyAreBorn) {
  Tracks tracks(2);
  const auto slot = tracks.create(3, 4, 99);
  EXPECT_EQ(tracks[slot].phase, Phase::kTentative);
  EXPECT_FALSE(tracks[slot].has_id());
  EXPECT_EQ(tracks[slot].id, -1);
  EXPECT_EQ(tracks[slot].x, 3);
  EXPECT_EQ(tracks.life(slot).kalman.y, 4);
  EXPECT_EQ(tracks.life(slot).kalman.stamp, 99U);
  EXPECT_EQ(tracks.life(slot).last_event, 99U);
}

TEST(Tracks, ATableHasAnEnd) {
  Tracks tracks(2);
  EXPECT_NE(tracks.create(0, 0, 0), Tracks::kNone);
  const auto second = tracks.create(0, 0, 0);
  EXPECT_EQ(tracks.create(0, 0, 0), Tracks::kNone);
  tracks.remove(second);
  EXPECT_EQ(tracks.create(0, 0, 0), second);
}

TEST(Tracks, ASlotThatIsGivenBackIsAnotherGeneration) {
  Tracks tracks(1);
  const auto slot = tracks.create(0, 0, 0);
  const auto generation = tracks[slot].generation;
  tracks.contour(slot).radius[0] = 5;
  tracks.life(slot).mass = 7;
  tracks.remove(slot);
  EXPECT_NE(tracks[slot].generation, generation);
  tracks.create(0, 0, 0);
  EXPECT_NE(tracks[slot].generation, generation);
  EXPECT_EQ(tracks.contour(slot).radius[0], 0);
  EXPECT_EQ(tracks.life(slot).mass, 0);
  const auto second = tracks[slot].generation;
  tracks.clear();
  EXPECT_NE(tracks[slot].generation, second);
}

TEST(Tracks, ActiveOnesAreListedByAge) {
  Tracks tracks(3);
  const auto a = tracks.create(0, 0, 0);
  const auto b = tracks.create(0, 0, 0);
  const auto c = tracks.create(0, 0, 0);
  tracks.remove(b);
  EXPECT_EQ(tracks.active(), (std::vector<Tracks::Slot>{a, c}));
  const auto d = tracks.create(0, 0, 0);
  EXPECT_EQ(tracks.active(), (std::vector<Tracks::Slot>{a, c, d}));
}

}  // namespace
}  // namespace track_test
