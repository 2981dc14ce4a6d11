#include "algorithms/fast/split.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <utility>

namespace asap::fast::split_test {
namespace {

// ---- objects that separated ----

// A track at (50, 50) in a frame of 100 x 100, cells of 4 px.
struct PartScene {
  CellMap map{100, 100, 4};
  OwnerGrid owners{map};
  Tracks tracks{4};
  PartFinder parts{map};
  Tracks::Slot slot = tracks.create(50, 50, 0);

  PartScene() {
    owners.clear(0);
    tracks[slot].phase = Phase::kConfirmed;
    tracks.state(slot).extent_px = 16;
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
  PartScene frame;
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
  PartScene frame;
  frame.own(40, 48, 2, 2);
  frame.own(52, 48, 2, 2);  // columns 10, 11 and 13, 14
  EXPECT_EQ(frame.find().size(), 1U);
  PartScene apart;
  apart.own(40, 48, 2, 2);
  apart.own(56, 48, 2, 2);
  EXPECT_EQ(apart.find().size(), 2U);
}

TEST(Split, PartsShareByCells) {
  PartScene frame;
  frame.own(20, 48, 3, 2);
  frame.own(60, 48, 3, 6);
  const auto parts = frame.find();
  EXPECT_FLOAT_EQ(share_of(parts[0], parts), 0.25F);
  EXPECT_FLOAT_EQ(share_of(parts[1], parts), 0.75F);
}

TEST(PartFinder, IgnoresSmallStaleAndForeignCells) {
  PartScene frame;
  frame.own(20, 48, 3, 1);
  EXPECT_TRUE(frame.find().empty());
  frame.own(60, 40, 2, 4);
  EXPECT_EQ(frame.find(40'000).size(), 1U);
  EXPECT_TRUE(frame.find(40'001).empty());
  ++frame.tracks[frame.slot].generation;
  EXPECT_TRUE(frame.find().empty());
}

TEST(PartFinder, LooksAtTheFrameOnlyAndAtFourParts) {
  PartScene frame;
  frame.own(0, 0, 25, 25);
  frame.tracks[frame.slot].x = -30;
  EXPECT_EQ(frame.find().size(), 1U);
  PartScene many;
  for (const std::size_t x : {20U, 44U, 68U}) {
    for (const std::size_t y : {20U, 44U}) many.own(x, y, 2, 2);
  }
  EXPECT_EQ(many.find().size(), PartFinder::kMaxParts);
}

TEST(Split, NeedsAGrownTrackWithoutContact) {
  Track track;
  TrackState state;
  track.phase = Phase::kConfirmed;
  state.extent_px = 9;
  state.average_extent2 = 40;
  EXPECT_TRUE(extent_has_grown(track, state));
  state.average_extent2 = 41;
  EXPECT_FALSE(extent_has_grown(track, state));
  state = {};
  state.extent_px = 7.9F;
  EXPECT_FALSE(extent_has_grown(track, state));
  state.extent_px = 8.1F;
  EXPECT_TRUE(extent_has_grown(track, state));
  track.partners = 1;
  EXPECT_FALSE(extent_has_grown(track, state));
}

TEST(Split, FindsThePartNearestToThePrediction) {
  PartScene frame;
  frame.own(20, 48, 3, 2);
  frame.own(60, 48, 3, 2);
  Track& track = frame.tracks[frame.slot];
  TrackState& state = frame.tracks.state(frame.slot);
  state.kalman.x = 30;
  state.kalman.y = 50;
  EXPECT_LT(part_at_prediction(frame.find(), track, state, 0)->x, 40);
  track.vx = 2000;
  track.stamp = 20'000;
  EXPECT_GT(part_at_prediction(frame.find(20'000), track, state, 20'000)->x, 40);
  EXPECT_EQ(part_at_prediction(frame.find().first(1), track, state, 0), nullptr);
}

TEST(Split, SharesMassAndRestarts) {
  PartScene frame;
  frame.own(20, 48, 3, 2);
  frame.own(60, 48, 3, 2);
  const auto parts = frame.find();
  const auto child = frame.tracks.create(0, 0, 0);
  Track& track = frame.tracks[frame.slot];
  TrackState& state = frame.tracks.state(frame.slot);
  track.events = 500;
  track.vx = 77;
  state.events = 490;
  state.mass = 100;
  state.slow_rate_hz = 1000;
  frame.tracks.contour(frame.slot).count.fill(5);
  begin_at_part(frame.tracks, frame.slot, child, parts[1], 0.25F, 4);
  restart_at_part(frame.tracks, frame.slot, parts[0], 0.75F, 4, 9);
  EXPECT_EQ(frame.tracks[child].vx, 77);
  EXPECT_EQ(frame.tracks.state(child).mass, 25);
  EXPECT_EQ(state.mass, 75);
  EXPECT_EQ(state.slow_rate_hz, 750);
  EXPECT_EQ(track.events, 30U);
  EXPECT_EQ(track.events - state.events, 10U);  // not yet counted
  EXPECT_EQ(track.x, parts[0].x);
  EXPECT_EQ(state.kalman.x, parts[0].x);
  EXPECT_NEAR(track.sxx, 6 * 16 / 10.0, 1e-4);
  EXPECT_EQ(frame.tracks.contour(frame.slot).count[0], 0);
}

// ---- unresolved objects ----

constexpr GateRule kGate{.birth_radius_px = 18,
                         .min_radius_px = 7,
                         .max_radius_px = 40,
                         .scale = 2.3F,
                         .padding_px = 2,
                         .circle_scale = 2.2F,
                         .circle_padding_px = 5};

struct Unresolved {
  Track track{};
  Contour contour{};
  TrackState state{};
  float noise_hz = 0;

  Unresolved() {
    track.phase = Phase::kConfirmed;
    track.events = 100;
    track.sxx = 110.5F;
    track.syy = 40.9F;
    contour.variance = 4.1F;
    state.average_extent2 = 110;
    state.age_s = 0.05F;
    state.slow_rate_hz = 1000;
    state.near_confirmed = false;
  }
  bool looks() const { return looks_unresolved(track, contour, state, noise_hz, kGate); }
};

TEST(LooksUnresolved, IfLongWithoutOutlineOrNeighbour) {
  EXPECT_TRUE(Unresolved().looks());
  const std::function<void(Unresolved&)> reasons[] = {
      [](Unresolved& d) { d.track.phase = Phase::kCoasting; },
      [](Unresolved& d) { d.track.partners = 1; },
      [](Unresolved& d) { d.state.near_confirmed = true; },
      [](Unresolved& d) { d.state.starved_s = 0.001F; },
      [](Unresolved& d) { d.state.age_s = 0.03F; },
      [](Unresolved& d) { d.track.events = 99; },
      [](Unresolved& d) { d.contour.variance = 3.9F; },
      [](Unresolved& d) { d.track.syy = 41; },
      [](Unresolved& d) { d.state.average_extent2 = 111; },
  };
  for (std::size_t i = 0; i < std::size(reasons); ++i) {
    Unresolved single;
    reasons[i](single);
    EXPECT_FALSE(single.looks()) << i;
  }
}

TEST(LooksUnresolved, NoiseScattersEventsToo) {
  Unresolved noisy;
  noisy.noise_hz = 0.1F;  // 112 of 1000 events/s
  EXPECT_FALSE(noisy.looks());
  noisy.contour.variance = 10.6F;
  EXPECT_FALSE(noisy.looks());
  noisy.contour.variance = 10.8F;
  EXPECT_TRUE(noisy.looks());
}

TEST(LooksUnresolved, Needs30Ms) {
  TrackState state;
  state.unresolved_s = 0.029F;
  EXPECT_FALSE(is_unresolved(state));
  state.unresolved_s = 0.031F;
  EXPECT_TRUE(is_unresolved(state));
}

// A track at (50, 50) in a frame of 100 x 100, cells of 4 px.
struct HalfScene {
  static constexpr Stamp kNow = 100'000;

  CellMap map{100, 100, 4};
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
          kNow - age, tracks[slot].generation, static_cast<std::uint8_t>(slot),
          static_cast<std::int8_t>(on-- > 0 ? 1 : -1)};
    }
  }
  auto find() { return halves.find(owners, tracks, slot, kNow); }
};

TEST(HalfFinder, CutsAcrossTheLongAxisPredictedHalfFirst) {
  HalfScene frame;
  frame.own(32, 48, 2);
  frame.own(60, 52, 2);
  for (const float x : {36.0F, 64.0F}) {
    frame.tracks.state(frame.slot).kalman.x = x;
    const auto halves = frame.find();
    ASSERT_EQ(halves.size(), 2U);
    EXPECT_FLOAT_EQ(halves[0].x, x - 0.5F);
    EXPECT_FLOAT_EQ(halves[0].y, (x < 50 ? 52 : 56) - 0.5F);
    EXPECT_FLOAT_EQ(halves[1].x, 100 - x - 0.5F);
    for (const auto& half : halves) {
      ASSERT_EQ(half.cells.size(), 4U);
      const std::size_t left = half.x < 50 ? 32 : 60;
      for (const std::size_t cell : half.cells) {
        const std::size_t column = cell % frame.map.stride() - 1;
        EXPECT_TRUE(column == left / 4 || column == left / 4 + 1);
      }
    }
  }
}

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

TEST(HalfFinder, AnEdgeIsNotAnObject) {
  for (const int on : {0, 1, 3, 4}) {
    HalfScene frame;
    frame.own(32, 48, 2);
    frame.own(60, 48, on);
    EXPECT_TRUE(frame.find().empty()) << on;
    HalfScene turned;
    turned.own(32, 48, on);
    turned.own(60, 48, 2);
    EXPECT_TRUE(turned.find().empty()) << on;
  }
}

TEST(HalfFinder, OldForeignAndFewCellsDoNotCount) {
  HalfScene frame;
  EXPECT_TRUE(frame.find().empty());
  frame.own(32, 48, 2);
  frame.own(60, 48, 2, 20'000);
  EXPECT_EQ(frame.find().size(), 2U);
  frame.own(60, 48, 2, 20'001);
  EXPECT_TRUE(frame.find().empty());
  frame.own(60, 48, 2);
  frame.owners[frame.map.cell(60, 48)].slot = 3;
  EXPECT_TRUE(frame.find().empty());
  frame.own(60, 48, 2);
  ++frame.owners[frame.map.cell(60, 48)].generation;
  EXPECT_TRUE(frame.find().empty());
}

TEST(HalfFinder, ASmallObjectHasNoHalves) {
  HalfScene frame;
  frame.own(44, 48, 2);
  frame.own(52, 48, 2);
  EXPECT_EQ(frame.find().size(), 2U);  // 8 px
  HalfScene small;
  for (const std::size_t x : {48U, 52U}) {
    for (std::size_t y = 44; y < 60; y += 4) {
      small.owners[small.map.cell(x, y)] = {HalfScene::kNow, small.tracks[small.slot].generation,
                                            static_cast<std::uint8_t>(small.slot),
                                            static_cast<std::int8_t>(x == 48 ? 1 : -1)};
    }
  }
  EXPECT_EQ(small.find().size(), 2U);
  for (const std::size_t x : {48U, 52U}) {
    small.owners[small.map.cell(x, 44)].stamp = HalfScene::kNow - 50'000;
  }
  EXPECT_TRUE(small.find().empty());  // 2 x 3 cells: too few each
}

// Halves at this distance, the second in this direction, of a track that looks unresolved.
struct Seen {
  TrackState state;

  bool look(float age_s, float px, float degrees = 0) {
    const float angle = degrees * 3.14159265F / 180;
    const Part halves[] = {{50, 50, {}},
                           {50 + px * std::cos(angle), 50 + px * std::sin(angle), {}}};
    state.age_s = age_s;
    state.unresolved_s = 0.04F;
    return distance_has_changed(state, halves);
  }
};

TEST(DistanceHasChanged, EitherWayAndByAMinimum) {
  for (const float sign : {-1.0F, 1.0F}) {
    Seen near;
    EXPECT_FALSE(near.look(1, 12));
    EXPECT_FALSE(near.look(1.01F, 12 + 2.9F * sign));
    EXPECT_EQ(near.state.unresolved_s, 0.04F);
    EXPECT_TRUE(near.look(1.02F, 12 + 3.1F * sign));
    EXPECT_EQ(near.state.unresolved_s, 0);
    EXPECT_FALSE(near.look(1.03F, 20));  // the first look of another split
    Seen wide;
    EXPECT_FALSE(wide.look(1, 30));
    EXPECT_FALSE(wide.look(1.01F, 30 + 5.9F * sign));
    EXPECT_TRUE(wide.look(1.02F, 30 + 6.1F * sign));
  }
}

TEST(DistanceHasChanged, AlongOneAxisWithin300Ms) {
  Seen turned;
  EXPECT_FALSE(turned.look(1, 12));
  EXPECT_FALSE(turned.look(1.01F, 18, 33));  // cosine 0.84: starts again
  EXPECT_FALSE(turned.look(1.02F, 18, 30));
  EXPECT_TRUE(turned.look(1.03F, 12, 180 + 30));  // either may come first
  Seen slow;
  EXPECT_FALSE(slow.look(1, 12));
  EXPECT_FALSE(slow.look(1.31F, 18));
  EXPECT_FALSE(slow.look(1.60F, 18));
  EXPECT_TRUE(slow.look(1.60F, 12));
}

TEST(DistanceHasChanged, WithoutHalvesTheFirstOffsetIsKept) {
  Seen seen;
  EXPECT_FALSE(seen.look(1, 12));
  EXPECT_FALSE(distance_has_changed(seen.state, {}));
  EXPECT_EQ(seen.state.unresolved_s, 0);
  EXPECT_TRUE(seen.look(1.01F, 18));
}

TEST(ConfirmChild, SharesTheHistory) {
  HalfScene frame;
  const auto child = frame.tracks.create(60, 50, HalfScene::kNow);
  TrackState& parent = frame.tracks.state(frame.slot);
  parent.age_s = 2;
  parent.confirmed_s = 1.5F;
  parent.slow_rate_hz = 600;
  parent.fast_rate_hz = 300;
  parent.average_vx = 70;
  parent.kalman.pvv = 100;
  for (const auto slot : {frame.slot, child}) {
    frame.tracks[slot].sxx = frame.tracks[slot].syy = 16;
    frame.tracks.contour(slot).variance = 12;
    frame.tracks.state(slot).young_radius_px = 18;
  }
  confirm_child(frame.tracks, frame.slot, child, 0.25F, kGate);
  const TrackState& state = frame.tracks.state(child);
  EXPECT_TRUE(frame.tracks[child].has_id());
  EXPECT_EQ(state.age_s, 2);
  EXPECT_EQ(state.confirmed_s, 1.5F);
  EXPECT_FLOAT_EQ(state.slow_rate_hz, 200);
  EXPECT_FLOAT_EQ(state.fast_rate_hz, 100);
  EXPECT_EQ(state.average_vx, 70);
  EXPECT_EQ(parent.kalman.pvv, state.kalman.pvv);
  for (const auto slot : {frame.slot, child}) {
    EXPECT_EQ(frame.tracks.contour(slot).variance, 2);
    EXPECT_EQ(frame.tracks.state(slot).average_extent2, 16);
    EXPECT_FLOAT_EQ(frame.tracks[slot].inverse_circle2, 1 / (13.8F * 13.8F));
  }
}

}  // namespace
}  // namespace asap::fast::split_test
