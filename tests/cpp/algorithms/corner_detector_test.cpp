#include "asap/algorithms/corner_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

namespace corner_detector_test {
namespace {

using std::chrono::microseconds;

using asap::ArcStar;
using asap::EFast;
using asap::EHarris;
using asap::Event;
using asap::FAHarris;
using Labels = std::vector<std::uint8_t>;

template <class Detector>
Labels labels_of(Detector& detector, const std::vector<Event>& events) {
  Labels labels(events.size(), 7);
  detector.process(events, labels);
  return labels;
}

template <class Detector>
class CornerDetector : public testing::Test {
 protected:
  // Every detector finds corners in it.
  static const std::vector<Event>& stream() {
    static const auto events = asap::test::golden_corner_stream(60'000);
    return events;
  }
  Detector detector_{{.width = 346, .height = 260}};
};

using Detectors = testing::Types<asap::EFast, asap::ArcStar, asap::EHarris, asap::FAHarris>;
TYPED_TEST_SUITE(CornerDetector, Detectors);

TYPED_TEST(CornerDetector, CountsWhatItLabels) {
  const auto labels = labels_of(this->detector_, this->stream());
  const auto corners = std::count(labels.begin(), labels.end(), 1);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 0) + corners, 60'000);
  TypeParam other{this->detector_.config()};
  EXPECT_GT(corners, 0);
  EXPECT_EQ(other.process(this->stream()), static_cast<std::size_t>(corners));
}

TYPED_TEST(CornerDetector, TheStreamMayBeCutAnywhere) {
  const auto labels = labels_of(this->detector_, this->stream());
  TypeParam other{this->detector_.config()};
  Labels again(labels.size(), 7);
  for (std::size_t i = 0; i < again.size();) {
    const std::size_t n = std::min<std::size_t>(i % 997, again.size() - i) + (i % 997 == 0);
    other.process(asap::EventSpan(this->stream()).subspan(i, n), std::span(again).subspan(i, n));
    i += n;
  }
  EXPECT_EQ(again, labels);
}

TYPED_TEST(CornerDetector, ResetIsANewDetector) {
  const auto labels = labels_of(this->detector_, this->stream());
  const std::vector<Event> outside{{.x = 346, .y = 0, .p = 0, .t = 1 << 30}};
  this->detector_.process(outside);
  this->detector_.reset();
  EXPECT_EQ(this->detector_.rejected(), 0U);
  EXPECT_EQ(labels_of(this->detector_, this->stream()), labels);
}

TYPED_TEST(CornerDetector, DropsAndCountsEventsOutsideTheFrame) {
  const auto labels = labels_of(this->detector_, this->stream());
  std::vector<Event> mixed;
  Labels expected;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (i % 10 == 0) {  // far ahead: a stamp that is looked at would show
      mixed.push_back({.x = 346, .y = 100, .p = 1, .t = 1LL << 60});
      mixed.push_back({.x = 100, .y = 260, .p = 0, .t = 1LL << 60});
      expected.insert(expected.end(), {0, 0});
    }
    mixed.push_back(this->stream()[i]);
    expected.push_back(labels[i]);
  }
  this->detector_.reset();
  EXPECT_EQ(labels_of(this->detector_, mixed), expected);
  EXPECT_EQ(this->detector_.rejected(), 12'000U);
}

TYPED_TEST(CornerDetector, AStampThatGoesBackCountsAsTheLatest) {
  auto jagged = this->stream();
  auto lifted = jagged;
  for (std::size_t i = 1; i < jagged.size(); i += 3) {
    jagged[i].t -= 1 + static_cast<std::int64_t>(i % 200'000);
    lifted[i].t = lifted[i - 1].t;
  }
  const auto labels = labels_of(this->detector_, lifted);
  this->detector_.reset();
  EXPECT_EQ(labels_of(this->detector_, jagged), labels);
}

TYPED_TEST(CornerDetector, AMillionEventsOnOneStampAndOnePixel) {
  const std::vector<Event> flash(1'000'000, Event{.x = 50, .y = 50, .p = 1, .t = 5});
  EXPECT_EQ(this->detector_.process(flash), 0U);
  auto same = this->stream();
  for (Event& event : same) event.t = 5;
  this->detector_.process(same);
  EXPECT_EQ(this->detector_.rejected(), 0U);
}

TYPED_TEST(CornerDetector, SurvivesAnyStampAndPolarity) {
  constexpr std::int64_t kLow = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kHigh = std::numeric_limits<std::int64_t>::max();
  TypeParam detector{{.width = 30, .height = 20}};
  const asap::CounterRandom random(1);
  std::vector<Event> events;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const std::uint64_t bits = random(i);
    const std::int64_t stamps[] = {kLow, kHigh, 0, -1, static_cast<std::int64_t>(random(~i))};
    events.push_back({.x = static_cast<std::uint16_t>(bits % 32),
                      .y = static_cast<std::uint16_t>((bits >> 8) % 22),
                      .p = static_cast<std::int16_t>(bits >> 16),
                      .t = stamps[(bits >> 32) % (i < 10'000 ? 1 : 5)]});
  }
  detector.process(events);
  EXPECT_GT(detector.rejected(), 0U);
}

TYPED_TEST(CornerDetector, KeepIsCheckedAndWithoutEffect) {
  TypeParam told{this->detector_.config()};
  told.set_keep(0.1);
  EXPECT_EQ(labels_of(told, this->stream()), labels_of(this->detector_, this->stream()));
  EXPECT_NO_THROW(told.set_keep(0));
  EXPECT_NO_THROW(told.set_keep(1));
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(told.set_keep(bad), std::invalid_argument);
  }
}

TYPED_TEST(CornerDetector, LabelsOfAnotherSizeAreRefused) {
  const std::vector<Event> events(3, Event{.x = 346, .y = 0, .p = 0, .t = 0});
  Labels labels(2);
  EXPECT_THROW(this->detector_.process(events, labels), std::invalid_argument);
  EXPECT_EQ(this->detector_.rejected(), 0U);
}

TYPED_TEST(CornerDetector, NamesBadSides) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { TypeParam({.width = 0, .height = 10}); }),
            "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of([] { TypeParam({.width = 10, .height = -2}); }),
            "height = -2: must be 1 to 16384 px");
}

TYPED_TEST(CornerDetector, MovesWithItsState) {
  const auto labels = labels_of(this->detector_, this->stream());
  const std::size_t half = labels.size() / 2;
  const auto first = std::span(this->stream()).first(half);
  const auto rest = std::span(this->stream()).subspan(half);
  TypeParam begun{this->detector_.config()};
  begun.process(first);
  TypeParam moved(std::move(begun));
  TypeParam other({.width = 1, .height = 1});
  other = std::move(moved);
  Labels again(rest.size());
  other.process(rest, again);
  EXPECT_TRUE(std::equal(again.begin(), again.end(), labels.end() - std::ssize(again)));
  EXPECT_EQ(other.config().width, 346);
}

TYPED_TEST(CornerDetector, AllocatesOnlyInTheConstructor) {
  Labels labels(this->stream().size());
  const std::size_t before = asap::test::allocations();
  this->detector_.process(this->stream(), labels);
  this->detector_.set_keep(0.5);
  this->detector_.reset();
  this->detector_.process(this->stream());
  EXPECT_EQ(asap::test::allocations(), before);
}

TEST(EFast, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  EFast({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 694);
  EXPECT_EQ(asap::test::hash_of(labels), 0x61ce6dcbU);
}

TEST(EFast, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const auto events = asap::test::wild_stream(wild, 20'000);
    Labels labels(events.size());
    EFast({.width = wild.width, .height = wild.height}).process(events, labels);
    ASSERT_EQ(labels, naive_labels(asap::test::NaiveEFast(wild.width, wild.height), events))
        << wild.seed;
    if (wild.width == 40) {
      EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 20) << wild.seed;
    }
  }
}

TEST(ArcStar, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  ArcStar({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 7354);
  EXPECT_EQ(asap::test::hash_of(labels), 0x287f6925U);
}

TEST(ArcStar, TheDefinitionTestsAsManyEventsAsTheRelease) {
  asap::test::NaiveArcStar naive(346, 260);
  for (const asap::Event& event : asap::test::golden_corner_stream()) naive.update(event);
  EXPECT_EQ(naive.tested(), 163'776U);
}

TEST(ArcStar, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    for (const std::int64_t filter_us : {0, 50'000}) {
      const auto events = asap::test::wild_stream(wild, 20'000);
      Labels labels(events.size());
      ArcStar({.width = wild.width, .height = wild.height, .filter = microseconds(filter_us)})
          .process(events, labels);
      const asap::test::NaiveArcStar naive(wild.width, wild.height, filter_us);
      ASSERT_EQ(labels, naive_labels(naive, events)) << wild.seed;
      if (wild.width == 40) {
        EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 20);
      }
    }
  }
}

TEST(ArcStar, NamesABadFilter) {
  EXPECT_EQ(asap::test::error_of(
                [] { ArcStar({.width = 10, .height = 10, .filter = microseconds(-1)}); }),
            "filter_us = -1: must be 0 to 500000000 us");
}

TEST(EHarris, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  EHarris({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 724);
  EXPECT_EQ(asap::test::hash_of(labels), 0x6df63b99U);
}

TEST(EHarris, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    for (const double threshold : {8.0, 1.5}) {
      const auto events = asap::test::wild_stream(wild, 6000);
      Labels labels(events.size());
      EHarris({.width = wild.width, .height = wild.height, .threshold = threshold})
          .process(events, labels);
      const asap::test::NaiveEHarris naive(wild.width, wild.height, threshold);
      ASSERT_EQ(labels, naive_labels(naive, events)) << wild.seed;
      if (wild.width == 40) {
        EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 5) << threshold;
      }
    }
  }
}

// Every pixel of a frame in turn: all windows are full, and the threshold lets all of them through.
TEST(EHarris, TestsOneColumnAndOneRowMoreThanTheRings) {
  std::vector<asap::Event> events;
  for (int round = 0; round < 2; ++round) {
    for (std::uint16_t y = 0; y < 12; ++y) {
      for (std::uint16_t x = 0; x < 15; ++x) events.push_back({.x = x, .y = y, .p = 0, .t = 0});
    }
  }
  Labels labels(events.size());
  EHarris({.width = 15, .height = 12, .threshold = -1e9}).process(events, labels);
  for (std::size_t i = 180; i < events.size(); ++i) {
    const auto [x, y, p, t] = events[i];
    EXPECT_EQ(labels[i] != 0, 4 <= x && x <= 11 && 4 <= y && y <= 8) << x << ' ' << y;
  }
}

TEST(EHarris, NamesABadThreshold) {
  EXPECT_EQ(asap::test::error_of([] {
              constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
              EHarris({.width = 10, .height = 10, .threshold = kNan});
            }),
            "threshold = nan: must be finite");
}

TEST(FAHarris, GoldenVector) {
  const auto events = asap::test::golden_corner_stream();
  Labels labels(events.size());
  FAHarris({.width = 346, .height = 260}).process(events, labels);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), 71);
  EXPECT_EQ(asap::test::hash_of(labels), 0x9a2dab8eU);
}

TEST(FAHarris, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    for (const double threshold : {8.0, -1.0}) {
      for (const std::int64_t filter_us : {0, 50'000}) {
        const auto events = asap::test::wild_stream(wild, 20'000);
        Labels labels(events.size());
        FAHarris({.width = wild.width,
                  .height = wild.height,
                  .filter = microseconds(filter_us),
                  .threshold = threshold})
            .process(events, labels);
        const asap::test::NaiveFAHarris naive(wild.width, wild.height, filter_us, threshold);
        ASSERT_EQ(labels, naive_labels(naive, events)) << wild.seed;
        if (wild.width == 40 && threshold < 0 && filter_us == 0) {
          EXPECT_GT(std::count(labels.begin(), labels.end(), 1), 5);
        }
      }
    }
  }
}

TEST(FAHarris, NamesBadParameters) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { FAHarris({.width = 10, .height = 10, .filter = microseconds(-1)}); }),
            "filter_us = -1: must be 0 to 500000000 us");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error_of([] { FAHarris({.width = 10, .height = 10, .threshold = kInfinity}); }),
            "threshold = inf: must be finite");
}

}  // namespace
}  // namespace corner_detector_test
