#include "asap/algorithms/event_image.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "support/errors.hpp"

namespace event_image_test {
namespace {

using std::chrono::microseconds;

using asap::Event;
using asap::EventImage;
using asap::EventImageConfig;
using asap::ImageView;
using enum asap::ImageChannel;
using Events = std::vector<Event>;
using Values = std::vector<float>;

constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();

struct Image {
  Values values;
  std::int64_t begin_us;
  std::int64_t end_us;

  friend bool operator==(const Image&, const Image&) = default;
};

Image copy_of(const ImageView& view) {
  return {{view.values.begin(), view.values.end()}, view.begin_us, view.end_us};
}

std::vector<Image> images_of(EventImage& image, asap::EventSpan events) {
  std::vector<Image> images;
  const std::size_t complete =
      image.process(events, [&](const ImageView& view) { images.push_back(copy_of(view)); });
  EXPECT_EQ(complete, images.size());
  return images;
}

// By definition: the events of each image, then one pass per channel.
std::vector<Image> naive_images(const EventImageConfig& config, const Events& events) {
  std::vector<std::vector<Event>> groups;
  for (const Event& event : events) {
    const auto period_of = [&](std::int64_t t) {
      const std::int64_t rest = t % config.period.count();
      return (t - rest) / config.period.count() - (rest < 0);
    };
    const bool fits =
        !groups.empty() &&
        (config.count > 0 ? groups.back().size() < static_cast<std::size_t>(config.count)
                          : period_of(groups.back().front().t) == period_of(event.t));
    if (!fits) groups.emplace_back();
    groups.back().push_back(event);
  }
  if (config.period.count() > 0 || groups.back().size() < static_cast<std::size_t>(config.count)) {
    groups.pop_back();  // not complete
  }
  std::vector<Image> images;
  const auto pixels = static_cast<std::size_t>(config.width * config.height);
  for (const auto& group : groups) {
    const std::int64_t first = group.front().t;
    const std::int64_t rest = config.period.count() > 0 ? first % config.period.count() : 0;
    const std::int64_t begin = first - rest - (rest < 0 ? config.period.count() : 0);
    const std::int64_t end =
        config.period.count() > 0 ? begin + config.period.count() : group.back().t + 1;
    Image image{Values(pixels * config.channels.size()), begin, end};
    for (std::size_t c = 0; c < config.channels.size(); ++c) {
      for (const Event& event : group) {
        const auto pixel = static_cast<std::size_t>(event.y * config.width + event.x);
        float& value = image.values[c * pixels + pixel];
        const bool is_on = event.p > 0;
        switch (config.channels[c]) {
          case off:
            value += !is_on;
            break;
          case on:
            value += is_on;
            break;
          case count:
            value += 1;
            break;
          case sum:
            value += is_on ? 1.0F : -1.0F;
            break;
          case time:
            value = static_cast<float>(static_cast<double>(event.t - begin + 1) /
                                       static_cast<double>(end - begin));
            break;
        }
      }
    }
    images.push_back(image);
  }
  return images;
}

float total(const Values& values) { return std::accumulate(values.begin(), values.end(), 0.0F); }

TEST(EventImage, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    if (wild.start_us == kMin) continue;  // the definition above would overflow
    const auto events = asap::test::wild_stream(wild, 2'000);
    for (const auto& [size, period] :
         std::map<std::int64_t, std::int64_t>{{1, 0}, {700, 0}, {2000, 0}, {0, 777}}) {
      const EventImageConfig config{.width = wild.width,
                                    .height = wild.height,
                                    .count = size,
                                    .period = microseconds(period),
                                    .channels = {sum, off, on, time, count}};
      EventImage image(config);
      const auto images = images_of(image, events);
      ASSERT_EQ(images, naive_images(config, events)) << wild.seed << ' ' << size;
      ASSERT_FALSE(images.empty());
      EXPECT_EQ(copy_of(image.image()), images.back());
    }
  }
}

TEST(EventImage, FlushCompletesWhatHasBegun) {
  EventImage image({.width = 1, .height = 1, .period = microseconds(100), .channels = {count}});
  EXPECT_FALSE(image.flush());
  const Events events{{.x = 0, .y = 0, .p = 1, .t = 250}};
  image.process(events);
  EXPECT_TRUE(image.flush());
  EXPECT_EQ(copy_of(image.image()), (Image{{1}, 200, 300}));
  EXPECT_FALSE(image.flush());
  EXPECT_EQ(image.process(events), 0U);  // the image begins anew
}

TEST(EventImage, BehindADiscarderItHoldsAsMuch) {
  const auto events = asap::test::golden_corner_stream(10'000);
  EventImage image({.width = 346, .height = 260, .count = 1000, .channels = {count}});
  image.set_gamma(0.25);
  auto images = images_of(image, std::span(events).first(5000));
  ASSERT_EQ(images.size(), 20U);  // of 250 events each
  for (const Image& one : images) EXPECT_EQ(total(one.values), 1000);

  image.set_gamma(1);  // at a package's boundary, in the middle of an image
  image.process(std::span(events).first(500));
  image.set_gamma(0.5);
  images = images_of(image, std::span(events).subspan(500, 250));
  ASSERT_EQ(images.size(), 1U);
  EXPECT_EQ(total(images[0].values), 1000);

  image.set_gamma(0);  // counts as kMinGamma
  images = images_of(image, std::span(events).first(3));
  EXPECT_EQ(images.size(), 3U);
  EXPECT_EQ(total(images[0].values), 1000);
}

TEST(EventImage, SurvivesAnyStampAndPolarity) {
  const Events events{{.x = 0, .y = 0, .p = -5, .t = kMin},
                      {.x = 0, .y = 0, .p = 300, .t = kMin + 3},
                      {.x = 0, .y = 0, .p = 1, .t = kMax - 1},
                      {.x = 0, .y = 0, .p = 0, .t = kMax}};
  EventImage periods(
      {.width = 1, .height = 1, .period = microseconds(1000), .channels = {off, on, time}});
  EXPECT_EQ(periods.process(events), 1U);
  EXPECT_EQ(periods.image().values[0], 1);
  EXPECT_EQ(periods.image().values[1], 1);
  EXPECT_TRUE(periods.flush());
  EXPECT_EQ(periods.image().end_us, kMax);
  for (const float value : periods.image().values) EXPECT_LE(value, 1);

  EventImage counts({.width = 1, .height = 1, .count = 4, .channels = {count, time}});
  EXPECT_EQ(counts.process(events), 1U);
  EXPECT_EQ(copy_of(counts.image()), (Image{{4, 1}, kMin, kMax}));
}

TEST(EventImage, TakesEitherACountOrAPeriod) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { EventImage({.width = 9, .height = 9}); }),
            "count = 0: give either count or period_us");
  EXPECT_EQ(error_of([] {
              EventImage({.width = 9, .height = 9, .count = 5, .period = microseconds(5)});
            }),
            "count = 5: give either count or period_us");
}

}  // namespace
}  // namespace event_image_test
