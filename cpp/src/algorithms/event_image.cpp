#include "asap/algorithms/event_image.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "algorithms/event_clock.hpp"
#include "algorithms/sensor_frame.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr std::int64_t kMaxCount = 1 << 24;  // floats count no further
constexpr std::int64_t kMaxPeriod_us = 1'000'000'000'000;

const EventImageConfig& checked(const EventImageConfig& config) {
  require(0 <= config.count && config.count <= kMaxCount, "count", config.count,
          "must be 0 to 16777216 events");
  require(0 <= config.period.count() && config.period.count() <= kMaxPeriod_us, "period_us",
          config.period.count(), "must be 0 to 10^12 us");
  require((config.count > 0) != (config.period.count() > 0), "count", config.count,
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

// Without overflow.
std::int64_t moved(std::int64_t stamp_us, std::uint64_t step_us) noexcept {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(stamp_us) + step_us);
}

}  // namespace

class EventImage::Impl {
 public:
  explicit Impl(const Config& given)
      : config(checked(given)),
        frame_(config.width, config.height),
        off_(std::size_t{frame_.width()} * frame_.height()),
        on_(off_.size()),
        times_us_(off_.size()),
        image_(off_.size() * config.channels.size()) {}

  bool take(EventSpan& events) noexcept {
    for (std::size_t i = 0; i < events.size(); ++i) {
      const Event& event = events[i];
      if (!frame_.contains(event)) [[unlikely]] {
        ++rejected;
        continue;
      }
      if (period_is_over(event.t)) {  // the event begins the next image
        close();
        events = events.subspan(i);
        return true;
      }
      advance(event.t);
      add(event);
      if (is_full()) {
        close();
        events = events.subspan(i + 1);
        return true;
      }
    }
    events = {};
    return false;
  }

  bool has_begun() const noexcept { return filled_ > 0; }

  void close() noexcept {
    // The newest event of an image by count is the last one seen.
    image_begin_us_ = begin_us_;
    image_end_us_ = plus(config.period.count() > 0 ? begin_us_ : last_us_,
                         config.period.count() > 0 ? config.period.count() : 1);
    float* out = image_.data();
    for (const ImageChannel channel : config.channels) {
      draw(channel, out);
      out += off_.size();
    }
    std::fill(off_.begin(), off_.end(), 0.0F);
    std::fill(on_.begin(), on_.end(), 0.0F);
    filled_ = 0;
  }

  ImageView image() const noexcept { return {image_, image_begin_us_, image_end_us_}; }

  void set_gamma(double gamma) noexcept { weight_ = 1 / std::max(gamma, kMinGamma); }

  void reset() noexcept {
    std::fill(off_.begin(), off_.end(), 0.0F);
    std::fill(on_.begin(), on_.end(), 0.0F);
    std::fill(image_.begin(), image_.end(), 0.0F);
    weight_ = 1;
    filled_ = 0;
    last_us_ = std::numeric_limits<std::int64_t>::min();
    image_begin_us_ = 0;
    image_end_us_ = 0;
    rejected = 0;
  }

  Config config;
  std::uint64_t rejected = 0;

 private:
  bool period_is_over(std::int64_t t_us) const noexcept {
    if (config.period.count() == 0 || !has_begun()) return false;
    if (t_us < last_us_) return begins_epoch(last_us_, t_us);
    return distance_us(begin_us_, t_us) >= static_cast<std::uint64_t>(config.period.count());
  }

  // As EventClock does. In a new epoch the image by count has begun as long ago as before.
  void advance(std::int64_t t_us) noexcept {
    if (t_us < last_us_) {
      if (!begins_epoch(last_us_, t_us)) return;
      const std::uint64_t step_us = distance_us(last_us_, t_us);
      begin_us_ = moved(begin_us_, step_us);
      epoch_us_ += step_us;
    }
    last_us_ = t_us;
  }

  bool is_full() const noexcept {
    return config.count > 0 && filled_ >= static_cast<double>(config.count);
  }

  void add(const Event& event) noexcept {
    if (!has_begun()) {
      begin_us_ =
          config.period.count() > 0 ? period_begin(last_us_, config.period.count()) : last_us_;
    }
    const std::size_t pixel = event.y * std::size_t{frame_.width()} + event.x;
    (event.p > 0 ? on_ : off_)[pixel] += static_cast<float>(weight_);
    times_us_[pixel] = moved(last_us_, -epoch_us_);
    filled_ += weight_;
  }

  void draw(ImageChannel channel, float* out) const noexcept {
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
    const double duration_us = static_cast<double>(distance_us(image_begin_us_, image_end_us_));
    const std::int64_t begin_us = moved(begin_us_, -epoch_us_);
    for (std::size_t i = 0; i < off_.size(); ++i) {
      const double age_us = static_cast<double>(distance_us(begin_us, times_us_[i])) + 1;
      const bool fired = on_[i] > 0 || off_[i] > 0;
      out[i] = fired ? static_cast<float>(std::min(age_us / duration_us, 1.0)) : 0.0F;
    }
  }

  SensorFrame frame_;
  std::vector<float> off_;  // belongs to the image that has begun
  std::vector<float> on_;
  std::vector<std::int64_t> times_us_;  // in the first epoch
  std::vector<float> image_;
  double weight_ = 1;
  double filled_ = 0;  // weight of the image that has begun
  std::int64_t begin_us_ = 0;
  std::uint64_t epoch_us_ = 0;  // from the first epoch's stamps to those of now
  std::int64_t last_us_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t image_begin_us_ = 0;
  std::int64_t image_end_us_ = 0;
};

EventImage::EventImage(const Config& config) : impl_(std::make_unique<Impl>(config)) {}
EventImage::~EventImage() = default;
EventImage::EventImage(const EventImage& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
EventImage& EventImage::operator=(const EventImage& other) { return *this = EventImage(other); }
EventImage::EventImage(EventImage&&) noexcept = default;
EventImage& EventImage::operator=(EventImage&&) noexcept = default;

bool EventImage::take(EventSpan& events) noexcept { return impl_->take(events); }

bool EventImage::flush() noexcept {
  if (!impl_->has_begun()) return false;
  impl_->close();
  return true;
}

ImageView EventImage::image() const noexcept { return impl_->image(); }

void EventImage::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  impl_->set_gamma(gamma);
}

void EventImage::reset() noexcept { impl_->reset(); }

std::uint64_t EventImage::rejected() const noexcept { return impl_->rejected; }

const EventImage::Config& EventImage::config() const noexcept { return impl_->config; }

}  // namespace asap::inline v0_1
