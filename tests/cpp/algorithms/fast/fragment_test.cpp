#include "algorithms/fast/fragment.hpp"

#include <gtest/gtest.h>

#include "algorithms/fast/gate.hpp"

namespace fragment_test {
namespace {

using namespace asap::fast;

constexpr GateRule kGate{.birth_radius_px = 18,
                         .min_radius_px = 7,
                         .max_radius_px = 40,
                         .scale = 2,
                         .padding_px = 0,
                         .circle_scale = 0,
                         .circle_padding_px = 0};

// A grown cluster whose gate is 24 px long and 16 px wide, either way, and a newborn.
struct Two {
  Tracks tracks{4};
  Tracks::Slot grown = add(Phase::kConfirmed, 100);
  Tracks::Slot newborn = add(Phase::kTentative, 19);

  Two() {
    tracks[grown].sxx = 144;
    tracks[grown].syy = 64;
    tracks.life(grown).age_s = 0.21F;
    shape_gate(tracks[grown], kGate, 144, true, 0);
  }
  Tracks::Slot add(Phase phase, float mass) {
    const auto slot = tracks.create(0, 0, 0);
    tracks[slot].phase = phase;
    tracks.life(slot).mass = mass;
    return slot;
  }
  void touch(Tracks::Slot other) { tracks.life(grown).partners[tracks[grown].partners++] = other; }
  bool wait(float dx, float dy) const { return may_be_fragment(tracks, newborn, grown, dx, dy); }
};

TEST(Fragment, LiesInTheWidenedGate) {
  const Two two;
  EXPECT_TRUE(two.wait(29.9F, 0));  // 1.25 x 24
  EXPECT_FALSE(two.wait(30.1F, 0));
  EXPECT_TRUE(two.wait(0, -19.9F));  // 1.25 x 16
  EXPECT_FALSE(two.wait(0, -20.1F));
}

TEST(Fragment, IsSmallBesideIt) {
  Two two;
  two.tracks.life(two.newborn).mass = 21;
  EXPECT_FALSE(two.wait(20, 0));
}

TEST(Fragment, IsOfAGrownOne) {
  Two two;
  two.tracks.life(two.grown).age_s = 0.19F;
  EXPECT_FALSE(two.wait(20, 0));
}

TEST(Fragment, IsNotSoughtInContact) {
  Two two;
  const auto other = two.add(Phase::kConfirmed, 100);
  two.touch(other);
  EXPECT_FALSE(two.wait(20, 0));
}

TEST(Fragment, AnEarlierFragmentIsNoOtherObject) {
  Two two;
  const auto earlier = two.add(Phase::kConfirmed, 10);
  two.touch(earlier);
  two.tracks.life(earlier).sibling = two.grown;
  two.tracks.life(earlier).sibling_generation = two.tracks[two.grown].generation;
  EXPECT_TRUE(two.wait(20, 0));
  two.touch(two.add(Phase::kConfirmed, 100));  // an object besides
  EXPECT_FALSE(two.wait(20, 0));
}

}  // namespace
}  // namespace fragment_test
