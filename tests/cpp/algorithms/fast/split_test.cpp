#include "algorithms/fast/split.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <utility>

namespace asap::fast::split_test {
namespace {

// A track at (50, 50) in a frame of 100 x 100, cells of 4 px.
struct HalfScene {
  static constexpr Stamp kNow = 100'000;

  CellMap map{100, 100};
  OwnerGrid owners{map};
  Tracks tracks{4};
  HalfFinder halves{map};
  Tracks::Slot slot = tracks.create(50, 50, kNow);

  HalfScene() {
    owners.clear(kNow);
    tracks[slot].phase = Phase::kConfirmed;
    tracks.state(slot).extent_px = 16;
    tracks.state(slot).kalman.stamp = kNow;
  }
  // 2 x 2 cells, `on` of them ON.
  void own(std::size_t x, std::size_t y, int on, Stamp age = 0) {
    for (std::size_t i = 0; i < 4; ++i) {
      owners[map.cell(x + 4 * (i % 2), y + 4 * (i / 2))] = {
          kNow - age, tracks[slot].generation, static_cast<std::uint8_t>(slot), on-- > 0};
    }
  }
  auto find() { return halves.find(owners, tracks, slot, kNow); }
};

TEST(HalfFinder, CutsAlongAnyAxis) {
  for (const auto& [x, y] : {std::pair{48U, 64U}, std::pair{60U, 60U}, std::pair{60U, 36U}}) {
    HalfScene frame;
    frame.own(x, y, 2);
    frame.own(96 - x, 96 - y, 2);
    const auto halves = frame.find();
    ASSERT_EQ(halves.size(), 2U);
    for (const auto& half : halves) EXPECT_EQ(half.cells.size(), 4U);
    const auto dx = static_cast<float>(2 * x) - 96;
    const auto dy = static_cast<float>(2 * y) - 96;
    EXPECT_FLOAT_EQ(halves[0].distance(halves[1]), length(dx, dy));
  }
}

TEST(HalfFinder, ABarHasNoHalves) {
  HalfScene bar;
  for (std::size_t x = 20; x <= 68; x += 8) bar.own(x, 48, 2);
  EXPECT_TRUE(bar.find().empty());
  HalfScene beside;  // one half is long, the other is not
  for (std::size_t x = 20; x <= 44; x += 8) beside.own(x, 48, 2);
  for (std::size_t y = 36; y <= 60; y += 8) beside.own(64, y, 2);
  EXPECT_EQ(beside.find().size(), 2U);
}

// The halves of one object that comes near or turns part too, and become longer with it.
TEST(HaveParted, SaysSoOfHalvesThatLieFartherApartThanThoseOfOneObject) {
  const auto parted = [](float spread_px, float later_spread_px, float birth_radius_px = 10) {
    TrackState state;
    const auto halves = [](float distance_px, float spread) {
      return std::array{Part{0, 0, {}, spread}, Part{distance_px, 0, {}, spread}};
    };
    EXPECT_FALSE(have_parted(state, halves(20, spread_px), birth_radius_px));
    EXPECT_FALSE(have_parted(state, halves(22, later_spread_px), birth_radius_px));
    return have_parted(state, halves(26, later_spread_px), birth_radius_px);
  };
  EXPECT_TRUE(parted(5.5F, 5.5F));
  EXPECT_FALSE(parted(5.5F, 7.5F));
  EXPECT_TRUE(parted(5.5F, 7.5F, 18));  // two that began unresolved may lie so near each other
}

// A sparse thing has gaps of its own.
TEST(ExtentHasGrown, SaysSoOfADenseTrackOnly) {
  Track track;
  track.phase = Phase::kConfirmed;
  for (const float scale : {1.0F, 3.0F}) {
    TrackState state;
    state.slow_rate_hz = 12'000 * scale;
    state.extent_px = 16 * scale;
    state.average_extent2 = 81 * scale * scale;
    EXPECT_TRUE(extent_has_grown(track, state, 15)) << scale;
    state.slow_rate_hz /= 4;
    EXPECT_FALSE(extent_has_grown(track, state, 15)) << scale;
  }
}

}  // namespace
}  // namespace asap::fast::split_test
