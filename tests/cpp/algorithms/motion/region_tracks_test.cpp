#include "algorithms/motion/region_tracks.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace asap::motion::region_tracks_test {
namespace {

Region region(double x, double vx = 0) {
  return {.centre = {x, 50}, .half_size = {8, 8}, .velocity = {vx, 0}, .size = 30, .t_last = 7};
}

std::vector<TrackedObject> read(const RegionTracks& tracks, std::int64_t ahead_us = 0) {
  std::vector<TrackedObject> objects;
  tracks.read(objects, ahead_us, true);
  return objects;
}

void step(RegionTracks& tracks, const std::vector<Region>& regions, int times = 1) {
  for (int i = 0; i < times; ++i) tracks.step(regions);
}

TEST(RegionTracks, ARegionIsToldAfterFourSteps) {
  RegionTracks tracks;
  step(tracks, {region(50)}, 3);
  EXPECT_TRUE(read(tracks).empty());
  step(tracks, {region(50)});
  ASSERT_EQ(read(tracks).size(), 1U);
  EXPECT_EQ(read(tracks)[0].left, 42);
  EXPECT_EQ(read(tracks)[0].width, 16);
  EXPECT_EQ(read(tracks)[0].age_us, 30'000);
}

TEST(RegionTracks, ATrackThatIsToldSurvivesTwoMissesAnotherNone) {
  RegionTracks tracks;
  step(tracks, {region(50)}, 4);
  step(tracks, {}, 2);
  EXPECT_EQ(read(tracks).size(), 1U);
  step(tracks, {region(50)});
  EXPECT_EQ(read(tracks).at(0).id, 0);
  step(tracks, {}, 3);
  EXPECT_TRUE(tracks.empty());
  step(tracks, {region(50)}, 3);
  step(tracks, {});
  EXPECT_TRUE(tracks.empty());
}

TEST(RegionTracks, ARegionGoesToTheNearestTrackAndAFarOneBeginsItsOwn) {
  RegionTracks tracks;
  step(tracks, {region(50), region(70)}, 4);
  step(tracks, {region(68), region(55), region(96)}, 4);
  const auto objects = read(tracks);
  ASSERT_EQ(objects.size(), 3U);
  EXPECT_LT(objects[0].x, 56);
  EXPECT_GT(objects[1].x, 66);
  EXPECT_EQ(objects[2].x, 96);
}

TEST(RegionTracks, ATrackTakesOneRegionWithinItsReach) {
  RegionTracks tracks;
  step(tracks, {region(50)}, 4);
  step(tracks, {region(76)});
  EXPECT_EQ(read(tracks).at(0).x, 50);
  tracks.clear();
  step(tracks, {region(50)}, 4);
  step(tracks, {region(48), region(56)}, 4);
  ASSERT_EQ(read(tracks).size(), 2U);
  EXPECT_LT(read(tracks)[0].x, 50);
}

TEST(RegionTracks, ATrackGoesOnWithItsVelocity) {
  RegionTracks tracks;
  for (int i = 0; i < 10; ++i) step(tracks, {region(50 + 5 * i, 500)});
  const auto now = read(tracks).at(0);
  EXPECT_NEAR(now.x, 95, 1e-9);
  EXPECT_NEAR(read(tracks, 10'000).at(0).x, 100, 1e-9);
  step(tracks, {});
  EXPECT_NEAR(read(tracks).at(0).x, 100, 1e-9);
  EXPECT_TRUE(read(tracks, 20'000).empty());  // a third miss on the way
}

TEST(RegionTracks, IsIndependentWhereTheBackgroundIsKnown) {
  RegionTracks tracks;
  step(tracks, {region(50)}, 4);
  EXPECT_EQ(read(tracks).at(0).independent, 1);
  std::vector<TrackedObject> objects;
  tracks.read(objects, 0, false);
  EXPECT_EQ(objects.at(0).independent, -1);
}

}  // namespace
}  // namespace asap::motion::region_tracks_test
