#include "algorithms/fast/objects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "algorithms/fast/engine.hpp"

namespace asap::fast::objects_test {
namespace {

// Tracks that stand where a test puts them, and the layer over them, every 5 ms.
struct Layer {
  Tracks tracks{16};
  NoiseTiles noise{346, 260};
  Objects objects{16};
  std::uint64_t now_us = EventClock::kOrigin_us;
  std::int32_t next_id = 0;

  // A confirmed track with both edges, unless it has one polarity.
  Tracks::Slot add(float x, float y, float sigma_px = 5, float mass = 100, float polarity = 0) {
    const Tracks::Slot slot = tracks.create(x, y, static_cast<Stamp>(now_us));
    Track& track = tracks[slot];
    track.phase = Phase::kConfirmed;
    track.id = next_id++;
    track.sxx = track.syy = sigma_px * sigma_px;
    track.events = tracks.state(slot).events = 100;
    tracks.state(slot).mass = mass;
    tracks.state(slot).slow_rate_hz = 5'000;
    tracks.contour(slot).polarity = polarity;
    const float side_px = 1.75F * sigma_px - 1;
    tracks.contour(slot).sides = {-side_px, -side_px, side_px, side_px};
    return slot;
  }

  void wait(std::uint64_t duration_us) {
    for (const std::uint64_t end = now_us + duration_us; now_us < end; now_us += 5'000) {
      for (const Tracks::Slot slot : tracks.active()) {
        const Point place = predicted_mean(tracks[slot], static_cast<Stamp>(now_us));
        tracks[slot].x = place.x;
        tracks[slot].y = place.y;
        tracks[slot].stamp = tracks.state(slot).last_event = static_cast<Stamp>(now_us);
      }
      objects.update(tracks, noise, now_us, next_id);
    }
  }

  std::int64_t id_of(Tracks::Slot slot) const {
    const std::size_t object = objects.object_of(slot, tracks[slot]);
    return object == Objects::kNone ? -1 : objects.id(object);
  }
  bool shows(Tracks::Slot slot) const {
    return objects.is_shown(objects.object_of(slot, tracks[slot]));
  }
};

TEST(Objects, EveryTrackIsAnObject) {
  Layer layer;
  const auto a = layer.add(50, 50);
  const auto b = layer.add(150, 50);
  layer.wait(5'000);
  EXPECT_EQ(layer.id_of(a), 0);
  EXPECT_EQ(layer.id_of(b), 1);
  EXPECT_TRUE(layer.shows(a));
}

// Where it was lost its own track finds its rear again, before what fires at its front is a track.
TEST(Objects, TheFrontOfWhatHasMovedOnIsAPartOfIt) {
  const auto id_of_front = [](float starved_s) {
    Layer layer;
    const auto track = layer.add(50, 50);
    layer.tracks[track].vx = layer.tracks.state(track).average_vx = 250;
    layer.wait(5'000);
    layer.tracks[track].vx = 0;
    layer.tracks.state(track).starved_s = starved_s;
    layer.wait(100'000);
    layer.tracks.state(track).starved_s = 0;
    layer.wait(20'000);
    const auto front = layer.add(84, 50);
    layer.wait(5'000);
    return layer.id_of(front);
  };
  EXPECT_EQ(id_of_front(1), 0);
  EXPECT_EQ(id_of_front(0), 1);  // the same beside one that was not hidden
}

// It moves 100 px/s: after 300 ms it is 30 px on.
TEST(Objects, ALostObjectIsTheOneThatReappearsOnItsWay) {
  const auto id_after = [](std::uint64_t gap_us, float x) {
    Layer layer;
    const auto lost = layer.add(50, 50);
    layer.tracks[lost].vx = layer.tracks.state(lost).average_vx = 100;
    layer.wait(5'000);
    layer.tracks.remove(lost);
    layer.wait(gap_us);
    const auto found = layer.add(x, 50);
    layer.wait(5'000);
    return layer.id_of(found);
  };
  EXPECT_EQ(id_after(300'000, 80), 0);
  EXPECT_EQ(id_after(300'000, 110), 0);  // half a box, 12 px and a third of the way beside it
  EXPECT_EQ(id_after(300'000, 120), 1);
  EXPECT_EQ(id_after(300'000, 30), 1);
  EXPECT_EQ(id_after(600'000, 110), 1);  // half a second is over
}

TEST(Objects, OfTwoLostObjectsTheNearestReappearsAndOnce) {
  Layer layer;
  const auto add_later = [&](float x) {
    layer.wait(40'000);  // those that begin together would be one
    return layer.add(x, 50, 2);
  };
  for (const float x : {50.0F, 66.0F, 80.0F}) add_later(x);
  layer.wait(5'000);
  while (!layer.tracks.active().empty()) layer.tracks.remove(layer.tracks.active().front());
  const auto found = add_later(68);
  const auto beside = add_later(70);
  const auto third = add_later(72);
  layer.wait(5'000);
  EXPECT_EQ(layer.id_of(found), 1);
  EXPECT_EQ(layer.id_of(beside), 2);
  EXPECT_EQ(layer.id_of(third), 5);  // its own: 0 is too far away
}

// A starved track coasts, so its place is no news of the object.
TEST(Objects, ALostObjectIsSoughtFromWhereItHadEvents) {
  Layer layer;
  const auto lost = layer.add(50, 50, 2);
  layer.wait(5'000);
  layer.tracks[lost].x = 100;
  layer.tracks.state(lost).starved_s = 0.02F;
  layer.wait(5'000);
  layer.tracks.remove(lost);
  const auto found = layer.add(50, 50, 2);
  layer.wait(5'000);
  EXPECT_EQ(layer.id_of(found), 0);
}

TEST(Objects, WhatBeginsAtALargeObjectIsAPartOfIt) {
  const auto id_beside = [](float sigma_px, float x, std::uint64_t age_us) {
    Layer layer;
    layer.add(100, 100, sigma_px);
    layer.wait(age_us);
    const auto piece = layer.add(x, 100, 3, 20);
    layer.wait(5'000);
    return layer.id_of(piece);
  };
  EXPECT_EQ(id_beside(21, 165, 200'000), 0);  // 73 px long; its reach ends at 168 px
  EXPECT_EQ(id_beside(21, 172, 200'000), 1);
  EXPECT_EQ(id_beside(9, 130, 200'000), 1);  // 31 px long
  EXPECT_EQ(id_beside(21, 165, 50'000), 1);  // too new to tell
}

TEST(Objects, WhatWasThereBeforeIsNoPart) {
  Layer layer;
  layer.add(100, 100, 21);
  const auto other = layer.add(250, 100, 3);
  layer.tracks[other].vx = -1'000;
  layer.wait(200'000);
  EXPECT_EQ(layer.id_of(other), 1);
}

TEST(Objects, APartThatStaysApartBecomesAnObject) {
  Layer layer;
  layer.add(100, 100, 21);
  layer.wait(200'000);
  const auto piece = layer.add(165, 100, 3, 20);
  layer.wait(20'000);
  ASSERT_EQ(layer.id_of(piece), 0);
  layer.tracks[piece].x = 200;
  layer.wait(60'000);
  EXPECT_EQ(layer.id_of(piece), 0);
  layer.wait(10'000);
  EXPECT_EQ(layer.id_of(piece), 2);  // 1 was the piece before it was adopted
  layer.tracks[piece].x = 165;
  layer.wait(200'000);
  EXPECT_EQ(layer.id_of(piece), 2);
}

TEST(Objects, APartThatComesBackInTimeStays) {
  Layer layer;
  layer.add(100, 100, 21);
  layer.wait(200'000);
  const auto piece = layer.add(165, 100, 3, 20);
  layer.wait(20'000);
  for (const float x : {200.0F, 165.0F, 200.0F}) {
    layer.tracks[piece].x = x;
    layer.wait(40'000);
    EXPECT_EQ(layer.id_of(piece), 0);
  }
}

TEST(Objects, TheLighterPartLeaves) {
  Layer layer;
  const auto first = layer.add(100, 100, 21);
  layer.wait(200'000);
  const auto piece = layer.add(165, 100, 3, 20);
  layer.wait(20'000);
  layer.tracks[piece].x = 260;
  layer.tracks.state(piece).mass = 200;
  layer.wait(70'000);
  EXPECT_EQ(layer.id_of(piece), 0);
  EXPECT_EQ(layer.id_of(first), 2);
}

// Two tracks 40 px apart that touch; the second one begins later.
struct Pair : Layer {
  explicit Pair(std::uint64_t later_us = 50'000) : first(add(50, 50, 8)) {
    wait(later_us);
    second = add(90, 50, 8, 50);
  }

  Tracks::Slot first;
  Tracks::Slot second;

  void move(float vx, float second_vx) {
    tracks[first].vx = vx;
    tracks[second].vx = second_vx;
  }
};

TEST(Objects, TwoThatBeginTogetherAreOneUntilTheyMoveApart) {
  Pair pair{20'000};
  pair.wait(5'000);
  EXPECT_EQ(pair.id_of(pair.second), 0);
  pair.move(0, 100);  // they touch until 80 ms, given up 40 ms later
  pair.wait(100'000);
  EXPECT_EQ(pair.id_of(pair.second), 0);
  pair.wait(40'000);
  EXPECT_EQ(pair.id_of(pair.second), 1);
}

TEST(Objects, TwoThatHaveOneEdgeEachAreOne) {
  const auto id_after = [](float polarity, float other_polarity) {
    Pair pair;
    pair.tracks.contour(pair.first).polarity = polarity;
    pair.tracks.contour(pair.second).polarity = other_polarity;
    pair.wait(40'000);
    return pair.id_of(pair.second);
  };
  EXPECT_EQ(id_after(0.7F, -0.7F), 0);
  EXPECT_EQ(id_after(0.7F, 0.7F), 1);
  EXPECT_EQ(id_after(0.7F, -0.5F), 1);  // an object of its own
}

// The ends of a bar that moves along itself, far apart, and two pieces of one line.
TEST(Objects, TheFrontAndTheRearOfAThingAreOne) {
  const auto id_after = [](float along_px2, float across_px2, float polarity) {
    Layer layer;
    layer.add(100, 100, 5, 100, 0.9F);
    const auto rear = layer.add(150, 100, 5, 100, polarity);
    for (const auto slot : layer.tracks.active()) {
      layer.tracks[slot].sxx = along_px2;
      layer.tracks[slot].syy = across_px2;
    }
    layer.wait(40'000);
    return layer.id_of(rear);
  };
  EXPECT_EQ(id_after(1, 16, -0.9F), 0);
  EXPECT_EQ(id_after(16, 1, -0.9F), 1);
  EXPECT_EQ(id_after(1, 16, 0.9F), 1);
  EXPECT_EQ(id_after(1, 4, -0.9F), 1);  // too far apart for their length
}

// Events of the one go to the other, whose mean moves with them, while the thing stands.
TEST(Objects, TwoThatAreOneStaySoWhileTheBoxAroundBothDoes) {
  Pair pair{20'000};
  pair.wait(5'000);
  pair.tracks[pair.second].x -= 12;
  Box& sides = pair.tracks.contour(pair.second).sides;
  sides = united(sides, sides.moved(12, 0)).moved(-6, 0);
  pair.wait(100'000);
  EXPECT_EQ(pair.id_of(pair.second), 0);
}

// Fills the tiles around (100, 100), where no track takes them, at a rate per pixel.
void add_noise(Layer& layer, double rate_hz) {
  const auto events = static_cast<int>(0.2 * 48 * 48 * rate_hz);
  for (int i = 0; i < events; ++i) {
    const auto at = static_cast<std::size_t>(i);
    layer.noise.count(80 + at % 48, 80 + at / 48 % 48);
  }
  layer.noise.update(0.2F);
}

TEST(Objects, NoiseThatIsDenserThanElsewhereIsNotShown) {
  for (const float polarity : {0.0F, 0.9F}) {
    Layer layer;
    add_noise(layer, 20);
    const auto patch = layer.add(104, 104, 5, 100, polarity);
    const auto shows = [&](float rate_hz) {
      layer.tracks.state(patch).slow_rate_hz = rate_hz;
      layer.wait(10'000);
      return layer.shows(patch);
    };
    // Its gate has 415 px, so the noise makes up to 8300 events per second.
    EXPECT_FALSE(shows(4'000));
    EXPECT_EQ(shows(40'000), polarity == 0);  // one edge alone must be more
    EXPECT_TRUE(shows(120'000));
    EXPECT_TRUE(shows(40'000));  // once shown, it stays
    EXPECT_FALSE(shows(4'000));
  }
}

// A moving thing has its ON events on one side and its OFF events on the other.
TEST(Objects, AThingWithEdgesApartIsShownAmongItsOwnUnsupportedEvents) {
  Layer layer;
  add_noise(layer, 20);
  const auto thing = layer.add(104, 104, 5);
  layer.tracks.state(thing).slow_rate_hz = 4'000;
  const auto shows = [&](float dipole_px) {
    layer.tracks.contour(thing).dipole_x = dipole_px;
    layer.wait(10'000);
    return layer.shows(thing);
  };
  EXPECT_FALSE(shows(3));
  EXPECT_TRUE(shows(4));
  EXPECT_FALSE(shows(3));
}

TEST(Objects, WhatFlickersIsHiddenUntilItHasClearlyCeased) {
  Layer layer;
  const auto slot = layer.add(104, 104);
  const auto shows = [&](float variance) {
    layer.tracks.contour(slot).average_polarity = 0.5F;
    layer.tracks.contour(slot).average_polarity2 = 0.25F + variance;
    layer.wait(5'000);
    return layer.shows(slot);
  };
  EXPECT_TRUE(shows(0));
  EXPECT_TRUE(shows(0.35F));
  EXPECT_FALSE(shows(0.45F));
  EXPECT_FALSE(shows(0.35F));
  EXPECT_TRUE(shows(0.25F));
}

TEST(Objects, NoiseEverywhereHidesNothing) {
  Layer layer;
  for (std::size_t i = 0; i < 20 * 346 * 260; ++i) layer.noise.count(i % 346, i / 346 % 260);
  layer.noise.update(1);
  ASSERT_NEAR(layer.noise.rate_hz(), 20, 1);
  const auto slot = layer.add(104, 104);
  layer.wait(5'000);
  EXPECT_TRUE(layer.shows(slot));
}

TEST(ObjectSum, AnObjectWithoutEventsIsQuiet) {
  constexpr Stamp kNow = 1'000'000;
  const auto is_quiet = [](float rate_hz, Stamp silent_us) {
    Track track;
    TrackState state;
    track.stamp = state.last_event = kNow - silent_us;
    state.slow_rate_hz = rate_hz;
    ObjectSum sum;
    sum.add(0, track, state, {}, kNow);
    return sum.is_quiet();
  };
  EXPECT_FALSE(is_quiet(5'000, 20'000));
  EXPECT_TRUE(is_quiet(5'000, 20'001));
  EXPECT_FALSE(is_quiet(100, 49'000));  // five events of this rate take 50 ms
  EXPECT_TRUE(is_quiet(100, 51'000));
}

TEST(ObjectSum, OnePartWithEventsIsEnough) {
  Layer layer;
  const auto silent = layer.add(100, 100);
  const auto firing = layer.add(110, 100);
  const auto now = static_cast<Stamp>(layer.now_us + 100'000);
  layer.tracks[firing].stamp = layer.tracks.state(firing).last_event = now;
  ObjectSum sum;
  for (const auto slot : {firing, silent}) {
    sum.add(slot, layer.tracks[slot], layer.tracks.state(slot), layer.tracks.contour(slot), now);
  }
  EXPECT_FALSE(sum.is_quiet());
}

TEST(ObjectSum, ItsPlaceIsThatOfTheHeaviestPartAndItsBoxThatOfAll) {
  Layer layer;
  const auto light = layer.add(100, 100, 4, 20);
  const auto heavy = layer.add(130, 110, 4, 50);
  ObjectSum sum;
  for (const auto slot : {light, heavy}) {
    sum.add(slot, layer.tracks[slot], layer.tracks.state(slot), layer.tracks.contour(slot),
            static_cast<Stamp>(layer.now_us));
  }
  EXPECT_EQ(sum.parts, 2U);
  EXPECT_EQ(sum.lead, heavy);
  EXPECT_EQ(sum.x, 130);
  EXPECT_EQ(sum.box.left, 93);
  EXPECT_EQ(sum.box.top, 93);
  EXPECT_EQ(sum.box.right, 137);
  EXPECT_EQ(sum.box.bottom, 117);
  EXPECT_EQ(sum.mass, 70);
}

// A plate of 60 x 12 px with texture moves along itself, among noise of 1 Hz per pixel or none.
TEST(Engine, TheBoxOfAnObjectHoldsWhatIsNotRound) {
  constexpr float kWidth_px = 60;
  constexpr float kHeight_px = 12;
  const auto overlap = [&](std::uint32_t noise_events) {
    Engine engine({.width = 346, .height = 260});
    std::minstd_rand random(1);
    const auto below = [&](std::uint32_t end) {
      return static_cast<std::uint32_t>(random()) % end;
    };
    std::vector<Event> events;
    float left = 40;
    for (std::int64_t t = 0; t < 300'000; t += 1'000, left += 0.2F) {
      for (std::uint32_t i = 0; i < 12 + noise_events; ++i) {
        const bool plate = i < 12;
        const std::uint32_t x = plate ? static_cast<std::uint32_t>(left) + below(60) : below(346);
        const std::uint32_t y = plate ? 100 + below(12) : below(260);
        events.push_back({.x = static_cast<std::uint16_t>(x),
                          .y = static_cast<std::uint16_t>(y),
                          .p = static_cast<std::int16_t>(below(2)),
                          .t = t});
      }
    }
    engine.process(events, nullptr);
    std::vector<TrackedObject> objects;
    engine.read(300'000, objects);
    if (objects.size() != 1) return 0.0;
    const TrackedObject& found = objects.front();
    const auto shared = [](double a, double a_length, double b, double b_length) {
      return std::max(0.0, std::min(a + a_length, b + b_length) - std::max(a, b));
    };
    const double both = shared(found.left, found.width, left - 0.5, kWidth_px) *
                        shared(found.top, found.height, 99.5, kHeight_px);
    return both / (kWidth_px * kHeight_px + found.width * found.height - both);
  };
  EXPECT_GT(overlap(0), 0.85);
  EXPECT_GT(overlap(90), 0.7);
}

// A lamp fires as a whole, ON when it is lit and OFF when it goes out.
TEST(Engine, ALampIsAClusterAndNoObject) {
  for (const std::int64_t half_us : {10'000, 5'000, 500}) {
    Engine engine({.width = 346, .height = 260});
    std::minstd_rand random(1);
    std::vector<Event> events;
    for (std::int64_t t = 0; t < 300'000; t += half_us) {
      for (int pixel = 0; pixel < 16 * 16; ++pixel) {
        events.push_back({.x = static_cast<std::uint16_t>(100 + pixel % 16),
                          .y = static_cast<std::uint16_t>(100 + pixel / 16),
                          .p = static_cast<std::int16_t>(t / half_us % 2),
                          .t = t + static_cast<std::int64_t>(random()) % (half_us / 5)});
      }
    }
    std::ranges::stable_sort(events, {}, &Event::t);
    engine.process(events, nullptr);
    std::vector<Cluster> clusters;
    engine.read(300'000, clusters);
    EXPECT_EQ(clusters.size(), 1U);
    std::vector<TrackedObject> objects;
    engine.read(300'000, objects);
    EXPECT_TRUE(objects.empty());
  }
}

// Of twice as many objects as slots, those that were lost first are forgotten for new ones.
TEST(Objects, TheTableIsNeverFull) {
  Layer layer;
  const auto ids_of_row = [&](float y) {
    std::vector<std::int64_t> ids;
    for (int i = 0; i < 16; ++i) layer.add(static_cast<float>(20 * i), y, 2);
    layer.wait(5'000);
    while (!layer.tracks.active().empty()) {
      const Tracks::Slot slot = layer.tracks.active().front();
      ids.push_back(layer.id_of(slot));
      layer.tracks.remove(slot);
    }
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  EXPECT_EQ(ids_of_row(0).front(), 0);
  const auto second = ids_of_row(60);
  EXPECT_EQ(second.front(), 16);
  EXPECT_EQ(ids_of_row(120).front(), 32);
  EXPECT_EQ(ids_of_row(60), second);
  EXPECT_EQ(ids_of_row(0).front(), 64);
}

}  // namespace
}  // namespace asap::fast::objects_test
