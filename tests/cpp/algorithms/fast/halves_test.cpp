#include "algorithms/fast/halves.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>

#include "algorithms/fast/gate_rule.hpp"

namespace halves_test {
namespace {

using namespace asap::fast;

struct Doubtful {
  Track track{};
  Contour contour{};
  Life life{};
  float noise_hz = 0;

  Doubtful() {
    track.phase = Phase::kConfirmed;
    track.events = 100;
    track.mean_weight = 0.3F;
    track.sxx = 90;
    track.syy = 50;
    contour.variance = 4.1F;
    life.age_s = 0.05F;
    life.slow_rate_hz = 1000;
    life.near_confirmed = false;
  }
  bool looks() const { return looks_double(track, contour, life, noise_hz, kGate); }
};

TEST(LooksDouble, AloneLongAndWithoutOutline) {
  EXPECT_TRUE(Doubtful().looks());
  const std::function<void(Doubtful&)> reasons[] = {
      [](Doubtful& d) { d.track.phase = Phase::kCoasting; },
      [](Doubtful& d) { d.track.partners = 1; },
      [](Doubtful& d) { d.life.near_confirmed = true; },
      [](Doubtful& d) { d.life.starved_s = 0.001F; },
      [](Doubtful& d) { d.life.age_s = 0.03F; },
      [](Doubtful& d) { d.track.events = 99; },
      [](Doubtful& d) { d.contour.variance = 3.9F; },
      [](Doubtful& d) { d.track.mean_weight = 0.41F; },
      [](Doubtful& d) { d.track.syy = 51; },
  };
  for (std::size_t i = 0; i < std::size(reasons); ++i) {
    Doubtful single;
    reasons[i](single);
    EXPECT_FALSE(single.looks()) << i;
  }
}

TEST(LooksDouble, NoiseScattersToo) {
  Doubtful noisy;
  noisy.noise_hz = 0.1F;  // 112 of 1000 events/s
  EXPECT_FALSE(noisy.looks());
  noisy.contour.variance = 10.6F;
  EXPECT_FALSE(noisy.looks());
  noisy.contour.variance = 10.8F;
  EXPECT_TRUE(noisy.looks());
}

TEST(LooksDouble, IsBelievedAfter30Ms) {
  Life life;
  life.double_s = 0.029F;
  EXPECT_FALSE(is_double(life));
  life.double_s = 0.031F;
  EXPECT_TRUE(is_double(life));
}

// A track at (50, 50) in a frame of 100 x 100, cells of 4 px.
struct Frame {
  static constexpr Stamp kNow = 100'000;

  CellMap map{100, 100, 4};
  OwnerGrid owners{map};
  Tracks tracks{4};
  HalfFinder halves{map};
  Tracks::Slot slot = tracks.create(50, 50, kNow);

  Frame() {
    owners.clear(kNow);
    tracks[slot].phase = Phase::kConfirmed;
    tracks.life(slot).extent_px = 16;
    tracks.life(slot).kalman.stamp = kNow;
  }
  // 2 x 2 cells, so many of them ON.
  void own(std::size_t x, std::size_t y, int on, Stamp age = 0) {
    for (std::size_t i = 0; i < 4; ++i) {
      owners[map.cell(x + 4 * (i % 2), y + 4 * (i / 2))] = {
          kNow - age, tracks[slot].generation, static_cast<std::uint8_t>(slot),
          static_cast<std::int8_t>(on-- > 0 ? 1 : -1)};
    }
  }
  auto find() { return halves.find(owners, tracks, slot, kNow); }
};

TEST(HalfFinder, CutsAcrossTheLongAxisHomeFirst) {
  Frame frame;
  frame.own(32, 48, 2);
  frame.own(60, 52, 2);
  for (const float x : {36.0F, 64.0F}) {
    frame.tracks.life(frame.slot).kalman.x = x;
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
    Frame frame;
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

TEST(HalfFinder, AnEdgeIsNoObject) {
  for (const int on : {0, 1, 3, 4}) {
    Frame frame;
    frame.own(32, 48, 2);
    frame.own(60, 48, on);
    EXPECT_TRUE(frame.find().empty()) << on;
    Frame turned;
    turned.own(32, 48, on);
    turned.own(60, 48, 2);
    EXPECT_TRUE(turned.find().empty()) << on;
  }
}

TEST(HalfFinder, OldForeignAndFewCellsDoNotCount) {
  Frame frame;
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
  Frame frame;
  frame.own(44, 48, 2);
  frame.own(52, 48, 2);
  EXPECT_EQ(frame.find().size(), 2U);  // 8 px
  Frame small;
  for (const std::size_t x : {48U, 52U}) {
    for (std::size_t y = 44; y < 60; y += 4) {
      small.owners[small.map.cell(x, y)] = {Frame::kNow, small.tracks[small.slot].generation,
                                            static_cast<std::uint8_t>(small.slot),
                                            static_cast<std::int8_t>(x == 48 ? 1 : -1)};
    }
  }
  EXPECT_EQ(small.find().size(), 2U);
  for (const std::size_t x : {48U, 52U}) {
    small.owners[small.map.cell(x, 44)].stamp = Frame::kNow - 50'000;
  }
  EXPECT_TRUE(small.find().empty());  // 2 x 3 cells: too few each
}

// Halves so far apart, the second in such a direction; both looks are a doubt old.
struct Seen {
  Life life;

  bool look(float age_s, float px, float degrees = 0) {
    const float angle = degrees * 3.14159265F / 180;
    const HalfFinder::Part halves[] = {{50, 50, {}},
                                       {50 + px * std::cos(angle), 50 + px * std::sin(angle), {}}};
    life.age_s = age_s;
    life.double_s = 0.04F;
    return have_moved_apart(life, halves);
  }
};

TEST(HaveMovedApart, EitherWayAndByMoreThanEndsWaver) {
  for (const float sign : {-1.0F, 1.0F}) {
    Seen near;
    EXPECT_FALSE(near.look(1, 12));
    EXPECT_FALSE(near.look(1.01F, 12 + 2.9F * sign));
    EXPECT_EQ(near.life.double_s, 0.04F);
    EXPECT_TRUE(near.look(1.02F, 12 + 3.1F * sign));
    EXPECT_EQ(near.life.double_s, 0);
    EXPECT_FALSE(near.look(1.03F, 20));  // the first look of another doubt
    Seen wide;
    EXPECT_FALSE(wide.look(1, 30));
    EXPECT_FALSE(wide.look(1.01F, 30 + 5.9F * sign));
    EXPECT_TRUE(wide.look(1.02F, 30 + 6.1F * sign));
  }
}

TEST(HaveMovedApart, AlongOneAxisWithin300Ms) {
  Seen turned;
  EXPECT_FALSE(turned.look(1, 12));
  EXPECT_FALSE(turned.look(1.01F, 18, 33));  // cosine .84: begins anew
  EXPECT_FALSE(turned.look(1.02F, 18, 30));
  EXPECT_TRUE(turned.look(1.03F, 12, 180 + 30));  // either may come first
  Seen slow;
  EXPECT_FALSE(slow.look(1, 12));
  EXPECT_FALSE(slow.look(1.31F, 18));
  EXPECT_FALSE(slow.look(1.60F, 18));
  EXPECT_TRUE(slow.look(1.60F, 12));
}

TEST(HaveMovedApart, NoHalvesEndTheDoubtButNotTheMemory) {
  Seen seen;
  EXPECT_FALSE(seen.look(1, 12));
  EXPECT_FALSE(have_moved_apart(seen.life, {}));
  EXPECT_EQ(seen.life.double_s, 0);
  EXPECT_TRUE(seen.look(1.01F, 18));
}

TEST(RaiseTwin, SharesThePast) {
  Frame frame;
  const auto twin = frame.tracks.create(60, 50, Frame::kNow);
  Life& past = frame.tracks.life(frame.slot);
  past.age_s = 2;
  past.confirmed_s = 1.5F;
  past.slow_rate_hz = 600;
  past.fast_rate_hz = 300;
  past.usual_vx = 70;
  past.kalman.pvv = 100;
  for (const auto slot : {frame.slot, twin}) {
    frame.tracks[slot].sxx = frame.tracks[slot].syy = 16;
    frame.tracks.contour(slot).variance = 12;
  }
  raise_twin(frame.tracks, frame.slot, twin, 0.25F, kGate);
  const Life& life = frame.tracks.life(twin);
  EXPECT_TRUE(frame.tracks[twin].has_id());
  EXPECT_EQ(life.age_s, 2);
  EXPECT_EQ(life.confirmed_s, 1.5F);
  EXPECT_FLOAT_EQ(life.slow_rate_hz, 200);
  EXPECT_FLOAT_EQ(life.fast_rate_hz, 100);
  EXPECT_EQ(life.usual_vx, 70);
  EXPECT_EQ(past.kalman.pvv, life.kalman.pvv);
  for (const auto slot : {frame.slot, twin}) {
    EXPECT_EQ(frame.tracks.contour(slot).variance, 2);
    EXPECT_EQ(frame.tracks.life(slot).usual_extent2, 16);
    EXPECT_FLOAT_EQ(frame.tracks[slot].inverse_circle2, 1 / (13.8F * 13.8F));
  }
}

}  // namespace
}  // namespace halves_test
