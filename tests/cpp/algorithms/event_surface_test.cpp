#include "asap/algorithms/event_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_surfaces.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

namespace event_surface_test {
namespace {

using asap::Event;
using asap::SpeedInvariantTimeSurface;
using asap::ThresholdOrdinalSurface;

template <class Surface>
std::vector<int> values_of(const Surface& surface) {
  const auto [width, height, unused] = surface.config();
  std::vector<typename Surface::Value> values(static_cast<std::size_t>(width * height));
  surface.copy_to(values);
  return {values.begin(), values.end()};
}

template <class Surface>
class EventSurface : public testing::Test {
 protected:
  static const std::vector<Event>& stream() {
    static const auto events = asap::test::golden_corner_stream(20'000);
    return events;
  }
  Surface surface_{{.width = 346, .height = 260}};
};

using Surfaces = testing::Types<asap::ThresholdOrdinalSurface, asap::SpeedInvariantTimeSurface>;
TYPED_TEST_SUITE(EventSurface, Surfaces);

TYPED_TEST(EventSurface, TheNewestPixelIsAtTheTop) {
  this->surface_.process(this->stream());
  const auto values = values_of(this->surface_);
  const Event& newest = this->stream().back();
  EXPECT_EQ(this->surface_.at(newest.x, newest.y), *std::max_element(values.begin(), values.end()));
  EXPECT_EQ(this->surface_.at(newest.x, newest.y), values[newest.y * 346U + newest.x]);
}

TYPED_TEST(EventSurface, TheStreamMayBeCutAnywhere) {
  this->surface_.process(this->stream());
  TypeParam other{this->surface_.config()};
  for (std::size_t i = 0; i < this->stream().size();) {
    const std::size_t n = std::min<std::size_t>(i % 97 + 1, this->stream().size() - i);
    other.process(asap::EventSpan(this->stream()).subspan(i, n));
    other.process({});
    i += n;
  }
  EXPECT_EQ(values_of(other), values_of(this->surface_));
}

TYPED_TEST(EventSurface, ResetIsANewSurface) {
  this->surface_.process(this->stream());
  const auto values = values_of(this->surface_);
  const std::vector<Event> outside{{.x = 346, .y = 0, .p = 0, .t = 0}};
  this->surface_.process(outside);
  EXPECT_EQ(this->surface_.rejected(), 1U);
  this->surface_.reset();
  EXPECT_EQ(this->surface_.rejected(), 0U);
  EXPECT_EQ(values_of(this->surface_), values_of(TypeParam{this->surface_.config()}));
  this->surface_.process(this->stream());
  EXPECT_EQ(values_of(this->surface_), values);
}

TYPED_TEST(EventSurface, DropsAndCountsEventsOutsideTheFrame) {
  const std::vector<Event> outside{{.x = 346, .y = 0, .p = 0, .t = 0},
                                   {.x = 0, .y = 260, .p = 0, .t = 0},
                                   {.x = 65535, .y = 65535, .p = 0, .t = 0}};
  const auto empty = values_of(this->surface_);
  this->surface_.process(outside);
  EXPECT_EQ(this->surface_.rejected(), 3U);
  EXPECT_EQ(values_of(this->surface_), empty);
}

TYPED_TEST(EventSurface, OnlyTheOrderCounts) {
  auto odd = this->stream();
  constexpr std::int64_t kStamps[] = {0, -1, std::numeric_limits<std::int64_t>::max(),
                                      std::numeric_limits<std::int64_t>::min()};
  for (std::size_t i = 0; i < odd.size(); ++i) {
    odd[i].t = kStamps[i % 4];
    odd[i].p = static_cast<std::int16_t>(i);
  }
  TypeParam other{this->surface_.config()};
  other.process(odd);
  this->surface_.process(this->stream());
  EXPECT_EQ(values_of(other), values_of(this->surface_));
}

TYPED_TEST(EventSurface, ManyEventsOnOnePixel) {
  const std::vector<Event> flash(100'000, Event{.x = 50, .y = 50, .p = 1, .t = 5});
  this->surface_.process(std::span(flash).first(1));
  const auto one = values_of(this->surface_);
  this->surface_.process(flash);
  EXPECT_EQ(values_of(this->surface_), one);
}

TYPED_TEST(EventSurface, KeepIsCheckedAndWithoutEffect) {
  TypeParam told{this->surface_.config()};
  told.set_keep(0.1);
  told.process(this->stream());
  this->surface_.process(this->stream());
  EXPECT_EQ(values_of(told), values_of(this->surface_));
  EXPECT_NO_THROW(told.set_keep(0));
  EXPECT_NO_THROW(told.set_keep(1));
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(told.set_keep(bad), std::invalid_argument);
  }
}

TYPED_TEST(EventSurface, NamesBadSides) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { TypeParam({.width = 0, .height = 10}); }),
            "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of([] { TypeParam({.width = 10, .height = -2}); }),
            "height = -2: must be 1 to 16384 px");
}

TYPED_TEST(EventSurface, ACopyGoesItsOwnWay) {
  const auto half = std::span(this->stream()).first(this->stream().size() / 2);
  this->surface_.process(half);
  TypeParam copy = this->surface_;
  TypeParam other({.width = 1, .height = 1});
  other = copy;
  const auto before = values_of(copy);
  this->surface_.process(this->stream());
  EXPECT_EQ(values_of(copy), before);
  TypeParam moved = std::move(copy);
  copy = other;
  for (TypeParam* each : {&moved, &other, &copy}) {
    each->process(this->stream());
    EXPECT_EQ(values_of(*each), values_of(this->surface_));
  }
}

TYPED_TEST(EventSurface, AllocatesOnlyInTheConstructor) {
  std::vector<typename TypeParam::Value> out(346 * 260);
  const std::vector<asap::Event>& stream = this->stream();  // made when it is first asked for
  const std::size_t before = asap::test::allocations();
  this->surface_.process(stream);
  this->surface_.set_keep(0.5);
  this->surface_.copy_to(out);
  this->surface_.reset();
  EXPECT_EQ(asap::test::allocations(), before);
}

TEST(ThresholdOrdinalSurface, GoldenVector) {
  ThresholdOrdinalSurface surface({.width = 346, .height = 260});
  surface.process(asap::test::golden_corner_stream());
  const auto values = values_of(surface);
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0), 3'701'507);
  EXPECT_EQ(std::count(values.begin(), values.end(), 0), 346 * 260 - 14'803);
}

TEST(ThresholdOrdinalSurface, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 3'000);
    for (const int side : {3, 7, 15, 17, 127}) {
      ThresholdOrdinalSurface surface({.width = wild.width, .height = wild.height, .side = side});
      asap::test::NaiveThresholdOrdinalSurface naive(wild.width, wild.height, side);
      // The naive form of a huge neighbourhood costs 65 000 pixels per event.
      const std::size_t count = side == 127 ? 300 : events.size();
      for (std::size_t i = 0; i < count; ++i) {
        surface.process({&events[i], 1});
        naive.update(events[i]);
        if (i % 100 == 99) {
          ASSERT_EQ(values_of(surface), naive.values()) << wild.seed << ' ' << side << ' ' << i;
        }
      }
    }
  }
}

TEST(ThresholdOrdinalSurface, APixelLastsForTwoSidesOfEvents) {
  ThresholdOrdinalSurface surface({.width = 9, .height = 9, .side = 5});
  const Event old{.x = 4, .y = 4, .p = 0, .t = 0};
  const Event near{.x = 6, .y = 2, .p = 0, .t = 0};
  const Event far{.x = 7, .y = 4, .p = 0, .t = 0};
  surface.process({&old, 1});
  surface.process({&far, 1});
  EXPECT_EQ(surface.at(4, 4), 255);
  for (int lower = 254; lower >= 245; --lower) {
    surface.process({&near, 1});
    EXPECT_EQ(surface.at(4, 4), lower);
  }
  surface.process({&near, 1});
  EXPECT_EQ(surface.at(4, 4), 0);
  surface.process({&near, 1});
  EXPECT_EQ(surface.at(4, 4), 0);
}

TEST(ThresholdOrdinalSurface, NamesBadParameters) {
  using asap::test::error_of;
  for (const int bad : {-7, 1, 8, 129}) {
    EXPECT_EQ(error_of([&] { ThresholdOrdinalSurface({.width = 9, .height = 9, .side = bad}); }),
              "side = " + std::to_string(bad) + ": must be odd, 3 to 127 px");
  }
}

TEST(SpeedInvariantTimeSurface, GoldenVector) {
  SpeedInvariantTimeSurface surface({.width = 346, .height = 260});
  surface.process(asap::test::golden_corner_stream());
  const auto values = values_of(surface);
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0), 3'538'452);
  EXPECT_EQ(std::count(values.begin(), values.end(), 0), 346 * 260 - 32'952);
}

TEST(SpeedInvariantTimeSurface, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 3'000);
    for (const int radius : {1, 3, 4, 6, 127}) {
      SpeedInvariantTimeSurface surface(
          {.width = wild.width, .height = wild.height, .radius = radius});
      asap::test::NaiveSpeedInvariantTimeSurface naive(wild.width, wild.height, radius);
      // The naive form of a huge neighbourhood costs 65 000 pixels per event.
      const std::size_t count = radius == 127 ? 300 : events.size();
      for (std::size_t i = 0; i < count; ++i) {
        surface.process({&events[i], 1});
        naive.update(events[i]);
        if (i % 100 == 99) {
          ASSERT_EQ(values_of(surface), naive.values()) << wild.seed << ' ' << radius << ' ' << i;
        }
      }
    }
  }
}

TEST(SpeedInvariantTimeSurface, RanksPixelsByTheirLastEvent) {
  SpeedInvariantTimeSurface surface({.width = 9, .height = 9, .radius = 1});
  const Event a{.x = 4, .y = 4, .p = 0, .t = 0};
  const Event b{.x = 5, .y = 4, .p = 0, .t = 0};
  const Event c{.x = 4, .y = 5, .p = 0, .t = 0};
  for (const Event& event : {a, b, c}) surface.process({&event, 1});
  EXPECT_EQ(surface.at(4, 4), 7);
  EXPECT_EQ(surface.at(5, 4), 8);
  EXPECT_EQ(surface.at(4, 5), 9);
  surface.process({&b, 1});  // lowers what ranked above it, and nothing else
  EXPECT_EQ(surface.at(4, 4), 7);
  EXPECT_EQ(surface.at(5, 4), 9);
  EXPECT_EQ(surface.at(4, 5), 8);
}

TEST(SpeedInvariantTimeSurface, NamesBadParameters) {
  using asap::test::error_of;
  for (const int bad : {-1, 0, 128}) {
    EXPECT_EQ(
        error_of([&] { SpeedInvariantTimeSurface({.width = 9, .height = 9, .radius = bad}); }),
        "radius = " + std::to_string(bad) + ": must be 1 to 127 px");
  }
}

}  // namespace
}  // namespace event_surface_test
