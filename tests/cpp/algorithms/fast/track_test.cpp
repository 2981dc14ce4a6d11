#include "algorithms/fast/track.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace asap::fast::track_test {
namespace {

TEST(Innovation, IsAgainstThePredictedMean) {
  Track track;
  track.x = 10;
  track.y = 20;
  track.vx = 100;
  track.vy = -50;
  track.stamp = 0xfffffff0U;
  const auto s = innovation_of(track, 0xfffffff0U + 20'000, 15, 15);  // across the wrap
  EXPECT_FLOAT_EQ(s.mean_x, 12);
  EXPECT_FLOAT_EQ(s.mean_y, 19);
  EXPECT_FLOAT_EQ(s.dx, 3);
  EXPECT_FLOAT_EQ(s.dy, -4);
}

TEST(Tracks, BeginTentativeAtTheGivenPosition) {
  Tracks tracks(2);
  const auto slot = tracks.create(3, 4, 99);
  EXPECT_EQ(tracks[slot].phase, Phase::kTentative);
  EXPECT_FALSE(tracks[slot].has_id());
  EXPECT_EQ(tracks[slot].id, -1);
  EXPECT_EQ(tracks[slot].x, 3);
  EXPECT_EQ(tracks.state(slot).kalman.y, 4);
  EXPECT_EQ(tracks.state(slot).kalman.stamp, 99U);
  EXPECT_EQ(tracks.state(slot).last_event, 99U);
}

TEST(Tracks, TheTableHasAnEnd) {
  Tracks tracks(2);
  EXPECT_NE(tracks.create(0, 0, 0), Tracks::kNone);
  const auto second = tracks.create(0, 0, 0);
  EXPECT_EQ(tracks.create(0, 0, 0), Tracks::kNone);
  tracks.remove(second);
  EXPECT_EQ(tracks.create(0, 0, 0), second);
}

TEST(Tracks, AFreedSlotChangesItsGeneration) {
  Tracks tracks(1);
  const auto slot = tracks.create(0, 0, 0);
  const auto generation = tracks[slot].generation;
  tracks.contour(slot).radius[0] = 5;
  tracks.state(slot).mass = 7;
  tracks.remove(slot);
  EXPECT_NE(tracks[slot].generation, generation);
  tracks.create(0, 0, 0);
  EXPECT_NE(tracks[slot].generation, generation);
  EXPECT_EQ(tracks.contour(slot).radius[0], 0);
  EXPECT_EQ(tracks.state(slot).mass, 0);
  const auto second = tracks[slot].generation;
  tracks.clear();
  EXPECT_NE(tracks[slot].generation, second);
}

TEST(Tracks, ActiveTracksAreListedByAge) {
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
}  // namespace asap::fast::track_test
