#include "algorithms/fast/split.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <utility>

namespace split_test {
namespace {

using namespace asap::fast;

// A track at (50, 50) in a frame of 100 x 100, cells of 4 px.
struct Frame {
  CellMap map{100, 100, 4};
  OwnerGrid owners{map};
  Tracks tracks{4};
  PartFinder parts{map};
  Tracks::Slot slot = tracks.create(50, 50, 0);

  Frame() {
    owners.clear(0);
    tracks[slot].phase = Phase::kConfirmed;
    tracks.life(slot).extent_px = 16;
  }
  void own(std::size_t x, std::size_t y, std::size_t columns, std::size_t rows, Stamp stamp = 0) {
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t c = 0; c < columns; ++c) {
        owners[map.cell(x + 4 * c, y + 4 * r)] = {stamp, tracks[slot].generation,
                                                  static_cast<std::uint8_t>(slot)};
      }
    }
  }
  auto find(Stamp now = 0) { return parts.find(owners, tracks, slot, now, 40'000); }
};

TEST(PartFinder, FindsPartsWithAGap) {
  Frame frame;
  frame.own(20, 48, 3, 2);
  frame.own(60, 40, 2, 4);
  const auto parts = frame.find();
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_FLOAT_EQ(parts[0].x, 64 - 0.5F);
  EXPECT_FLOAT_EQ(parts[0].y, 48 - 0.5F);
  EXPECT_EQ(parts[0].cells.size(), 8U);
  EXPECT_FLOAT_EQ(parts[1].x, 26 - 0.5F);
  EXPECT_EQ(parts[1].cells.size(), 6U);
  EXPECT_EQ(parts[1].cells[0], frame.map.cell(20, 48));
}

TEST(PartFinder, AGapOfOneCellConnects) {
  Frame frame;
  frame.own(40, 48, 2, 2);
  frame.own(52, 48, 2, 2);  // columns 10, 11 and 13, 14
  EXPECT_EQ(frame.find().size(), 1U);
  Frame apart;
  apart.own(40, 48, 2, 2);
  apart.own(56, 48, 2, 2);
  EXPECT_EQ(apart.find().size(), 2U);
}

TEST(Split, PartsShareByCells) {
  Frame frame;
  frame.own(20, 48, 3, 2);
  frame.own(60, 48, 3, 6);
  const auto parts = frame.find();
  EXPECT_FLOAT_EQ(share_of(parts[0], parts), 0.25F);
  EXPECT_FLOAT_EQ(share_of(parts[1], parts), 0.75F);
}

TEST(PartFinder, SmallStaleAndForeignCellsDoNotCount) {
  Frame frame;
  frame.own(20, 48, 3, 1);
  EXPECT_TRUE(frame.find().empty());
  frame.own(60, 40, 2, 4);
  EXPECT_EQ(frame.find(40'000).size(), 1U);
  EXPECT_TRUE(frame.find(40'001).empty());
  ++frame.tracks[frame.slot].generation;
  EXPECT_TRUE(frame.find().empty());
}

TEST(PartFinder, LooksAtTheFrameOnlyAndAtFourParts) {
  Frame frame;
  frame.own(0, 0, 25, 25);
  frame.tracks[frame.slot].x = -30;
  EXPECT_EQ(frame.find().size(), 1U);
  Frame many;
  for (const std::size_t x : {20U, 44U, 68U}) {
    for (const std::size_t y : {20U, 44U}) many.own(x, y, 2, 2);
  }
  EXPECT_EQ(many.find().size(), PartFinder::kMaxParts);
}

TEST(Split, WantsATrackAloneThatHasGrown) {
  Track track;
  Life life;
  track.phase = Phase::kConfirmed;
  life.extent_px = 9;
  life.usual_extent2 = 40;
  EXPECT_TRUE(has_grown(track, life));
  life.usual_extent2 = 41;
  EXPECT_FALSE(has_grown(track, life));
  life = {};
  life.extent_px = 7.9F;
  EXPECT_FALSE(has_grown(track, life));
  life.extent_px = 8.1F;
  EXPECT_TRUE(has_grown(track, life));
  track.partners = 1;
  EXPECT_FALSE(has_grown(track, life));
}

TEST(Split, HomeIsNearestToThePrediction) {
  Frame frame;
  frame.own(20, 48, 3, 2);
  frame.own(60, 48, 3, 2);
  Track& track = frame.tracks[frame.slot];
  Life& life = frame.tracks.life(frame.slot);
  life.kalman.x = 30;
  life.kalman.y = 50;
  EXPECT_LT(home_of(frame.find(), track, life, 0)->x, 40);
  track.vx = 2000;
  track.stamp = 20'000;
  EXPECT_GT(home_of(frame.find(20'000), track, life, 20'000)->x, 40);
  EXPECT_EQ(home_of(frame.find().first(1), track, life, 0), nullptr);
}

TEST(Split, SharesMassAndBeginsAnew) {
  Frame frame;
  frame.own(20, 48, 3, 2);
  frame.own(60, 48, 3, 2);
  const auto parts = frame.find();
  const auto child = frame.tracks.create(0, 0, 0);
  Track& track = frame.tracks[frame.slot];
  Life& life = frame.tracks.life(frame.slot);
  track.events = 500;
  track.vx = 77;
  life.events = 490;
  life.mass = 100;
  life.slow_rate_hz = 1000;
  frame.tracks.contour(frame.slot).count.fill(5);
  inherit_part(frame.tracks, frame.slot, child, parts[1], 0.25F, 4);
  keep_part(frame.tracks, frame.slot, parts[0], 0.75F, 4, 9);
  EXPECT_EQ(frame.tracks[child].vx, 77);
  EXPECT_EQ(frame.tracks.life(child).mass, 25);
  EXPECT_EQ(life.mass, 75);
  EXPECT_EQ(life.slow_rate_hz, 750);
  EXPECT_EQ(track.events, 30U);
  EXPECT_EQ(track.events - life.events, 10U);  // still new
  EXPECT_EQ(track.x, parts[0].x);
  EXPECT_EQ(life.kalman.x, parts[0].x);
  EXPECT_NEAR(track.sxx, 6 * 16 / 10.0, 1e-4);
  EXPECT_EQ(frame.tracks.contour(frame.slot).count[0], 0);
}

}  // namespace
}  // namespace split_test
