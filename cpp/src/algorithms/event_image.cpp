#include "asap/algorithms/event_image.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr std::int64_t kMaxCount = 1 << 24;  // floats count no further
constexpr std::int64_t kMaxPeriod_us = 1'000'000'000'000;

const EventImageConfig& checked(const EventImageConfig& config) {
  require(0 <= config.count && config.count <= kMaxCount, "count", config.count,
          "must be 0 to 16777216 events");
  require(0 <= config.period_us && config.period_us <= kMaxPeriod_us, "period_us", config.period_us,
          "must be 0 to 10^12 us");
  require((config.count > 0) != (config.period_us > 0), "count", config.count,
          "give either count or period_us");
  require(!config.channels.empty(), "channels.size()", config.channels.size(),
          "an image has at least one channel");
  return config;
}

std::int64_t plus(std::int64_t stamp_us, std::int64_t duration_us) noexcept {
  constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max();
  return stamp_us > kLatest - duration_us ? kLatest : stamp_us + duration_us;
}

// The multiple of the period at or before the stamp; the first of all where there is none.
std::int64_t period_begin(std::int64_t stamp_us, std::int64_t period_us) noexcept {
  const std::int64_t rest = stamp_us % period_us;
  const std::int64_t into = rest < 0 ? rest + period_us : rest;
  constexpr std::int64_t kEarliest = std::numeric_limits<std::int64_t>::min();
  return stamp_us < kEarliest + into ? kEarliest : stamp_us - into;
}

}  // namespace

EventImage::EventImage(const Config& config)
    : config_(checked(config)),
      frame_(config.width, config.height),
      off_(std::size_t{frame_.width()} * frame_.height()),
      on_(off_.size()),
      times_us_(off_.size()),
      image_(off_.size() * config.channels.size()) {}

void EventImage::begin() noexcept {
  begin_us_ = config_.period_us > 0 ? period_begin(last_us_, config_.period_us) : last_us_;
}

void EventImage::close() noexcept {
  // By count the newest event of the image is the last one seen.
  image_begin_us_ = begin_us_;
  image_end_us_ = plus(config_.period_us > 0 ? begin_us_ : last_us_,
                       config_.period_us > 0 ? config_.period_us : 1);
  float* out = image_.data();
  for (const ImageChannel channel : config_.channels) {
    draw(channel, out);
    out += off_.size();
  }
  std::fill(off_.begin(), off_.end(), 0.0F);
  std::fill(on_.begin(), on_.end(), 0.0F);
  filled_ = 0;
}

void EventImage::draw(ImageChannel channel, float* out) const noexcept {
  switch (channel) {
    case ImageChannel::off:
      std::copy(off_.begin(), off_.end(), out);
      return;
    case ImageChannel::on:
      std::copy(on_.begin(), on_.end(), out);
      return;
    case ImageChannel::count:
      std::transform(on_.begin(), on_.end(), off_.begin(), out, std::plus<>());
      return;
    case ImageChannel::sum:
      std::transform(on_.begin(), on_.end(), off_.begin(), out, std::minus<>());
      return;
    case ImageChannel::time:
      break;
  }
  // A stamp stands for the whole microsecond, so an event at the begin differs from none.
  const double duration_us = static_cast<double>(distance(image_begin_us_, image_end_us_));
  for (std::size_t i = 0; i < off_.size(); ++i) {
    const double age_us = static_cast<double>(distance(begin_us_, times_us_[i])) + 1;
    const bool fired = on_[i] > 0 || off_[i] > 0;
    out[i] = fired ? static_cast<float>(std::min(age_us / duration_us, 1.0)) : 0.0F;
  }
}

bool EventImage::flush() noexcept {
  if (!has_begun()) return false;
  close();
  return true;
}

void EventImage::set_keep(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  weight_ = 1 / std::max(gamma, kLeastKeep);
}

void EventImage::reset() noexcept {
  std::fill(off_.begin(), off_.end(), 0.0F);
  std::fill(on_.begin(), on_.end(), 0.0F);
  std::fill(image_.begin(), image_.end(), 0.0F);
  weight_ = 1;
  filled_ = 0;
  last_us_ = std::numeric_limits<std::int64_t>::min();
  image_begin_us_ = 0;
  image_end_us_ = 0;
  rejected_ = 0;
}

}  // namespace asap
