// What every algorithm keeps, whatever it finds: the stream may be cut anywhere, events outside the
// frame change nothing, a stamp that goes back counts as the latest, a silence or a stamp far ahead
// blinds it no longer than its memory, nothing is allocated after construction.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/event_image.hpp"
#include "asap/algorithms/event_surface.hpp"
#include "asap/algorithms/feature_tracker.hpp"
#include "asap/algorithms/motion_segmenter.hpp"
#include "asap/algorithms/noise_filters.hpp"
#include "asap/algorithms/plane_flow.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "study/scenes/moving_shapes.hpp"
#include "support/allocation_counter.hpp"

namespace asap::every_algorithm_test {
namespace {

constexpr std::size_t kEvents = 20'000;
constexpr int kWidth = 40;
constexpr int kHeight = 30;

struct ImageOfAPeriod : EventImage {
  using EventImage::EventImage;
};

template <class Algorithm>
Algorithm made(int width = kWidth, int height = kHeight) {
  typename Algorithm::Config config{.width = width, .height = height};
  if constexpr (std::is_same_v<Algorithm, EventImage>) config.count = 700;
  if constexpr (std::is_same_v<Algorithm, ImageOfAPeriod>) {
    config.period = std::chrono::milliseconds(3);
    config.channels.push_back(ImageChannel::time);
  }
  if constexpr (std::is_same_v<Algorithm, HotPixelMask>) config.learn_events = 700;
  return Algorithm(config);
}

// Whether it gives every event such an answer.
template <class Algorithm, class Answer>
concept Answers = !std::is_base_of_v<EventImage, Algorithm> &&
                  requires(Algorithm& algorithm, std::span<Answer> answers) {
                    algorithm.process(EventSpan(), answers);
                  };

// All that an algorithm has said, in memory taken beforehand.
class Seen {
 public:
  Seen() { numbers.reserve(400'000); }

  template <class Algorithm>
  void process(Algorithm& algorithm, EventSpan events) {
    if constexpr (Answers<Algorithm, Event>) {
      note(events_, algorithm.process(events, events_));
    } else if constexpr (Answers<Algorithm, std::uint8_t>) {
      answer(algorithm, events, bytes_);
    } else if constexpr (Answers<Algorithm, std::int32_t>) {
      answer(algorithm, events, ids_);
    } else if constexpr (Answers<Algorithm, Flow>) {
      answer(algorithm, events, flows_);
    } else {
      look_at(algorithm, events);
    }
    if constexpr (std::is_same_v<Algorithm, PublishedClusterTracker>) {
      algorithm.clusters(clusters_);
      position = clusters_.empty() ? position : std::pair{clusters_[0].x, clusters_[0].vx};
    }
  }

  // The ids that a tracker gave, in the order in which they came.
  Seen renamed() const {
    Seen other = *this;
    std::map<double, double> names{{-1, -1}};
    for (double& id : other.numbers) {
      id = names.try_emplace(id, static_cast<double>(names.size())).first->second;
    }
    return other;
  }

  friend bool operator==(const Seen& a, const Seen& b) {
    return a.numbers == b.numbers && a.position == b.position;
  }

  std::vector<double> numbers;
  std::pair<double, double> position;  // and velocity, of the first cluster

 private:
  static double number_of(std::int32_t answer) { return answer; }
  static double number_of(const Flow& flow) { return std::isnan(flow.vx) ? 1e30 : flow.vx; }
  static double number_of(const Event& event) { return event.x + 100 * event.y; }

  template <class Answer>
  void note(const std::vector<Answer>& answers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) numbers.push_back(number_of(answers[i]));
  }

  template <class Algorithm, class Answer>
  void answer(Algorithm& algorithm, EventSpan events, std::vector<Answer>& answers) {
    algorithm.process(events, std::span(answers).first(events.size()));
    note(answers, events.size());
  }

  // What it holds.
  template <class Surface>
    requires requires { typename Surface::Value; }
  void look_at(Surface& surface, EventSpan events) {
    surface.process(events);
    const auto [width, height, unused] = surface.config();
    numbers.clear();
    for (std::uint16_t y = 0; y < height; ++y) {
      for (std::uint16_t x = 0; x < width; ++x) numbers.push_back(surface.at(x, y));
    }
  }
  void look_at(EventImage& image, EventSpan events) {
    image.process(events, [this](const ImageView& view) {
      numbers.insert(numbers.end(), view.values.begin(), view.values.end());
    });
  }
  void look_at(MotionSegmenter& segmenter, EventSpan events) {
    segmenter.process(events);
    segmenter.objects(objects_);
    numbers.clear();
    numbers.push_back(static_cast<double>(objects_.size()));
    for (const TrackedObject& object : objects_)
      numbers.insert(numbers.end(), {object.x, object.vx});
    if (const auto motion = segmenter.camera_motion()) numbers.push_back(motion->vx);
  }

  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(kEvents + 10);
  std::vector<std::int32_t> ids_ = std::vector<std::int32_t>(kEvents + 10);
  std::vector<Flow> flows_ = std::vector<Flow>(kEvents + 10);
  std::vector<Event> events_ = std::vector<Event>(kEvents + 10);
  std::vector<Cluster> clusters_ = std::vector<Cluster>(1000);
  std::vector<TrackedObject> objects_ = std::vector<TrackedObject>(100);
};

template <class Algorithm>
Seen seen_by(Algorithm& algorithm, EventSpan events) {
  Seen seen;
  seen.process(algorithm, events);
  return seen;
}

// Small frames, in which every pixel fires many times, and scenes for the algorithms that need one.
template <class Algorithm>
struct Stream {
  int width = 16;
  int height = 12;
  std::vector<Event> events = test::wild_stream({.width = 16, .height = 12}, kEvents);
};

template <bool kHasGround, std::int64_t kDuration_us = 300'000>
struct Scene {
  int width = 160;
  int height = 120;
  std::vector<Event> events = [] {
    MovingShapesConfig config{
        .width = 160, .height = 120, .duration_us = kDuration_us, .noise_hz = 1, .seed = 7};
    const Bounce path{.start = {30, 60}, .velocity = {250, 0}, .low = {20, 20}, .high = {140, 100}};
    config.shapes.push_back({.radius_px = 12, .motion = {.path = path}});
    if (kHasGround) config.ground = MovingGroundConfig{.shift_px_s = {-80, 50}};
    MovingShapes shapes(config);
    return read_events(shapes, std::numeric_limits<std::size_t>::max());
  }();
};
template <>
struct Stream<ClusterTracker> : Scene<false> {};
template <>
struct Stream<FeatureTracker> {
  int width = kWidth;
  int height = kHeight;
  std::vector<Event> events = test::wild_stream({}, 2 * kEvents);
};
template <>
struct Stream<MotionSegmenter> : Scene<true, 120'000> {};  // the dearest of all

template <class Algorithm>
class EveryAlgorithm : public testing::Test {
 protected:
  // A scene for what finds nothing in a frame so small.
  static constexpr bool kIsScene = std::is_same_v<Algorithm, MotionSegmenter>;
  static constexpr int kColumns = kIsScene ? 160 : kWidth;
  static constexpr int kRows = kIsScene ? 120 : kHeight;

  static std::vector<Event> events() {
    if constexpr (!kIsScene) return test::wild_stream({}, kEvents);
    auto events = Scene<true>().events;
    events.resize(kEvents);
    return events;
  }

  const std::vector<Event> events_ = events();
  Algorithm algorithm_ = made<Algorithm>(kColumns, kRows);
  Algorithm other_ = made<Algorithm>(kColumns, kRows);
};

using Algorithms = testing::Types<EFast, ArcStar, EHarris, FAHarris, BackgroundActivityFilter,
                                  HotPixelMask, EventImage, ImageOfAPeriod, ThresholdOrdinalSurface,
                                  SpeedInvariantTimeSurface, PlaneFlow, PublishedClusterTracker,
                                  ClusterTracker, FeatureTracker, MotionSegmenter>;
TYPED_TEST_SUITE(EveryAlgorithm, Algorithms);

TYPED_TEST(EveryAlgorithm, TheStreamMayBeCutAnywhereAndResetIsANewOne) {
  const Seen whole = seen_by(this->algorithm_, this->events_);
  const std::vector<Event> outside{{.x = TestFixture::kColumns, .y = 0, .p = 0, .t = 1LL << 60}};
  seen_by(this->algorithm_, outside);
  EXPECT_EQ(this->algorithm_.rejected(), 1U);
  this->algorithm_.reset();
  EXPECT_EQ(this->algorithm_.rejected(), 0U);
  Seen parts;
  for (std::size_t i = 0; i < kEvents;) {
    const std::size_t n = std::min<std::size_t>(i % 997, kEvents - i) + (i % 997 == 0);
    parts.process(this->algorithm_, EventSpan(this->events_).subspan(i, n));
    i += n;
  }
  EXPECT_TRUE(parts == whole);
  const auto [least, most] = std::minmax_element(whole.numbers.begin(), whole.numbers.end());
  EXPECT_LT(*least, *most) << "it finds something";
}

TYPED_TEST(EveryAlgorithm, EventsOutsideTheFrameAreCountedAndChangeNothing) {
  Seen mixed;
  for (std::size_t i = 0; i < kEvents; i += 1000) {  // far ahead: a stamp that counts would show
    const std::vector<Event> outside{{.x = TestFixture::kColumns, .y = 9, .p = 1, .t = 1LL << 60},
                                     {.x = 9, .y = TestFixture::kRows, .p = 0, .t = 1LL << 60},
                                     {.x = 65535, .y = 65535, .p = 0, .t = 0}};
    seen_by(this->algorithm_, outside);
    mixed.process(this->algorithm_, EventSpan(this->events_).subspan(i, 1000));
  }
  EXPECT_EQ(this->algorithm_.rejected(), 3 * kEvents / 1000);
  Seen alone;
  for (std::size_t i = 0; i < kEvents; i += 1000) {
    alone.process(this->other_, EventSpan(this->events_).subspan(i, 1000));
  }
  EXPECT_TRUE(mixed == alone);
}

// The published rule fits its velocity to the stamps as they are.
TYPED_TEST(EveryAlgorithm, AStampThatGoesBackCountsAsTheLatest) {
  if constexpr (!std::is_base_of_v<PublishedClusterTracker, TypeParam>) {
    const CounterRandom random(2);
    auto jagged = this->events_;
    for (std::size_t i = 1; i < kEvents; i += 3) {
      jagged[i].t -= static_cast<std::int64_t>(random(i) % 100'000);
    }
    auto lifted = jagged;
    for (std::size_t i = 1; i < kEvents; ++i) lifted[i].t = std::max(lifted[i].t, lifted[i - 1].t);
    EXPECT_TRUE(seen_by(this->algorithm_, jagged) == seen_by(this->other_, lifted));
  }
}

TYPED_TEST(EveryAlgorithm, SurvivesAnyStampAndPolarity) {
  constexpr std::int64_t kLow = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kHigh = std::numeric_limits<std::int64_t>::max();
  const CounterRandom random(1);
  std::vector<Event> events;
  for (std::uint64_t i = 0; i < kEvents; ++i) {
    const std::uint64_t bits = random(i);
    const std::int64_t stamps[] = {kLow, kHigh, 0, -1, static_cast<std::int64_t>(random(~i))};
    events.push_back({.x = static_cast<std::uint16_t>(bits % (TestFixture::kColumns + 2)),
                      .y = static_cast<std::uint16_t>((bits >> 8) % (TestFixture::kRows + 2)),
                      .p = static_cast<std::int16_t>(bits >> 16),
                      .t = stamps[(bits >> 32) % (i < kEvents / 2 ? 1 : 5)]});
  }
  const Seen seen = seen_by(this->algorithm_, events);
  for (const double number : seen.numbers) ASSERT_TRUE(std::isfinite(number));
  EXPECT_TRUE(std::isfinite(seen.position.first) && std::isfinite(seen.position.second));
  EXPECT_GT(this->algorithm_.rejected(), 0U);
}

TYPED_TEST(EveryAlgorithm, KeepIsCheckedAndMostlyWithoutEffect) {
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(this->algorithm_.set_gamma(bad), std::invalid_argument);
  }
  this->algorithm_.set_gamma(0);
  this->algorithm_.set_gamma(0.1);
  const bool is_same =
      seen_by(this->algorithm_, this->events_) == seen_by(this->other_, this->events_);
  EXPECT_EQ(is_same, (!std::is_same_v<TypeParam, BackgroundActivityFilter> &&
                      !std::is_same_v<TypeParam, ClusterTracker> &&
                      !std::is_base_of_v<EventImage, TypeParam>));
}

TYPED_TEST(EveryAlgorithm, MovesWithItsStateAndACopyGoesItsOwnWay) {
  const auto first = EventSpan(this->events_).first(kEvents / 2);
  const auto second = EventSpan(this->events_).subspan(kEvents / 2);
  seen_by(this->algorithm_, first);
  seen_by(this->other_, first);
  TypeParam moved(std::move(this->other_));
  this->other_ = made<TypeParam>(1, 1);
  if constexpr (std::is_copy_constructible_v<TypeParam>) {
    TypeParam copy = moved;
    this->other_ = copy;
    seen_by(copy, second);
    const Seen expected = seen_by(this->algorithm_, second);
    EXPECT_TRUE(seen_by(this->other_, second) == expected);
    EXPECT_TRUE(seen_by(moved, second) == expected);
  } else {
    this->other_ = std::move(moved);
    EXPECT_TRUE(seen_by(this->other_, second) == seen_by(this->algorithm_, second));
  }
  EXPECT_EQ(this->other_.config().width, TestFixture::kColumns);
}

TYPED_TEST(EveryAlgorithm, AllocatesOnlyInTheConstructor) {
  Seen seen;
  const std::size_t before = test::allocations();
  seen.process(this->algorithm_, this->events_);
  this->algorithm_.set_gamma(0.5);
  this->algorithm_.reset();
  seen.process(this->algorithm_, EventSpan(this->events_).first(kEvents / 2));
  EXPECT_EQ(test::allocations(), before);
}

// ---- silences and stamps far away --------------------------------------------------------------

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::int64_t kMinute_us = 60 * kSecond_us;
constexpr std::int64_t kUnix_us = 1'700'000'000'000'000;

// A stream comes, then again `gap_us` after its first event began. If `ahead_us` is not 0, the last
// event of the first time is so much too late.
struct Journey {
  std::int64_t start_us;
  std::int64_t gap_us;
  std::int64_t ahead_us = 0;
};

std::vector<Journey> journeys() {
  std::vector<Journey> all;
  for (const std::int64_t gap_us :
       {10 * kSecond_us, 36 * kMinute_us, std::int64_t{1} << 32, 72 * kMinute_us, 180 * kMinute_us,
        30 * 24 * 60 * kMinute_us, kUnix_us}) {
    all.push_back({.start_us = 0, .gap_us = gap_us});
  }
  for (const int bits : {31, 32, 53}) {
    all.push_back({.start_us = std::int64_t{1} << bits, .gap_us = 36 * kMinute_us});
  }
  all.push_back({.start_us = kUnix_us, .gap_us = 72 * kMinute_us});
  all.push_back({.start_us = kUnix_us, .gap_us = -kUnix_us});  // the clock is set to 0
  for (const std::int64_t ahead_us : {kMinute_us, 36 * kMinute_us, 180 * kMinute_us, kUnix_us}) {
    all.push_back({.start_us = kUnix_us, .gap_us = 10 * kSecond_us, .ahead_us = ahead_us});
  }
  return all;
}

template <class Algorithm>
void feed(Algorithm& algorithm, Seen& seen, EventSpan events) {
  for (; !events.empty(); events = events.subspan(std::min(kEvents, events.size()))) {
    seen.process(algorithm, events.first(std::min(kEvents, events.size())));
  }
}

// Returns what the algorithm says of the second half of the events.
template <class Algorithm>
Seen second_half(Algorithm& algorithm, EventSpan events) {
  Seen memory, seen;
  feed(algorithm, memory, events.first(events.size() / 2));
  feed(algorithm, seen, events.subspan(events.size() / 2));
  return seen.renamed();
}

std::vector<Event> moved(std::vector<Event> events, std::int64_t by_us) {
  for (Event& event : events) event.t += by_us;
  return events;
}

// What ClusterTracker knows of the noise fades slowly, and a track of FeatureTracker may live on
// for as long as it has events: which events get an id is nearly the same, not which id.
template <class Algorithm>
bool is_as(const Seen& seen, const Seen& expected) {
  constexpr bool remembers =
      std::is_same_v<Algorithm, ClusterTracker> || std::is_same_v<Algorithm, FeatureTracker>;
  if constexpr (!remembers) return seen == expected;
  std::size_t differing = 0, labelled = 0;
  for (std::size_t i = 0; i < seen.numbers.size(); ++i) {
    differing += (seen.numbers[i] < 0) != (expected.numbers[i] < 0);
    labelled += expected.numbers[i] >= 0;
  }
  return 20 * differing < labelled;
}

// As one that is new there, or as if nothing had been: both where time does not count.
template <class Algorithm>
void goes_on_everywhere() {
  const Stream<Algorithm> stream;
  const auto fresh = [&] { return made<Algorithm>(stream.width, stream.height); };
  std::vector<Event> events = moved(stream.events, -stream.events.front().t);
  events.back().t += 10'000 - events.back().t % 10'000;  // MotionSegmenter works in such steps
  auto always = fresh();
  second_half(always, events);
  const Seen unbroken = second_half(always, moved(events, events.back().t));
  for (const Journey& way : journeys()) {
    auto first = moved(events, way.start_us);
    const auto again = moved(first, way.gap_us);
    first.back().t += way.ahead_us;
    auto travelled = fresh();
    auto other = fresh();
    second_half(travelled, first);
    const Seen seen = second_half(travelled, again);
    const Seen as_new = second_half(other, again);
    EXPECT_TRUE(is_as<Algorithm>(seen, as_new) || seen == unbroken)
        << "start " << way.start_us << " gap " << way.gap_us << " ahead " << way.ahead_us;
    const auto [least, most] = std::minmax_element(as_new.numbers.begin(), as_new.numbers.end());
    EXPECT_LT(*least, *most) << "it finds something";
  }
}

TYPED_TEST(EveryAlgorithm, ASilenceOrAStampFarAheadBlindsItNoLongerThanItsMemory) {
  goes_on_everywhere<TypeParam>();
}

// ---- other promises ----------------------------------------------------------------------------

template <class Answer, class Algorithm>
void refuses_answers_of_another_size(Algorithm& algorithm) {
  if constexpr (Answers<Algorithm, Answer>) {
    const std::vector<Event> events(3, Event{.x = 65535, .y = 0, .p = 0, .t = 0});
    std::vector<Answer> answers(2);
    EXPECT_THROW(algorithm.process(events, std::span(answers)), std::invalid_argument);
    EXPECT_EQ(algorithm.rejected(), 0U);
  }
}

TYPED_TEST(EveryAlgorithm, RefusesAnswersOfAnotherSize) {
  refuses_answers_of_another_size<std::uint8_t>(this->algorithm_);
  refuses_answers_of_another_size<std::int32_t>(this->algorithm_);
  refuses_answers_of_another_size<Flow>(this->algorithm_);
}

template <class Filter>
void may_write_over_its_input(Filter filter) {
  auto events = test::wild_stream({}, kEvents);
  const Seen expected = seen_by(filter, events);
  filter.reset();
  events.resize(filter.process(events, events));
  ASSERT_EQ(events.size(), expected.numbers.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    ASSERT_EQ(events[i].x + 100 * events[i].y, expected.numbers[i]);
  }
  EXPECT_LT(events.size(), kEvents);
}

TEST(EveryAlgorithm, AFilterMayWriteOverItsInput) {
  may_write_over_its_input(made<BackgroundActivityFilter>());
  may_write_over_its_input(HotPixelMask({.width = kWidth, .height = kHeight, .pixels = {{7, 9}}}));
}

}  // namespace
}  // namespace asap::every_algorithm_test
