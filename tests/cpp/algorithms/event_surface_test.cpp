#include "asap/algorithms/event_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "asap/algorithms/speed_invariant_time_surface.hpp"
#include "asap/algorithms/threshold_ordinal_surface.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

namespace event_surface_test {
namespace {

using asap::Event;

template <class Surface>
auto values_of(const Surface& surface) {
  std::vector<typename Surface::Value> values(346 * 260);
  surface.copy_to(values);
  return values;
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

}  // namespace
}  // namespace event_surface_test
