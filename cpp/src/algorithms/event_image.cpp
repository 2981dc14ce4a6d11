#include "asap/algorithms/event_image.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "algorithms/sensor_frame.hpp"
#include "core/check.hpp"
#include "core/event_clock.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr std::int64_t kMaxCount = 1 << 24;  // floats count no further
constexpr std::int64_t kMaxPeriod_us = 1'000'000'000'000;
constexpr std::int64_t kEarliest = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max();

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
  return stamp_us > kLatest - duration_us ? kLatest : stamp_us + duration_us;
}

// The multiple of the period at or before the timestamp; the first of all where there is none.
std::int64_t period_begin(std::int64_t stamp_us, std::int64_t period_us) noexcept {
  const std::int64_t rest = stamp_us % period_us;
  const std::int64_t into = rest < 0 ? rest + period_us : rest;
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
        pixels_(std::size_t{frame_.width()} * frame_.height()),
        is_plain_(config.channels == std::vector{ImageChannel::off, ImageChannel::on}),
        planes_(2 * pixels_),
        times_us_(std::ranges::count(config.channels, ImageChannel::time) > 0 ? pixels_ : 0),
        image_(pixels_ * config.channels.size()) {}

  bool take(EventSpan& events) noexcept {
    if (times_us_.empty()) return take<false>(events);
    return take<true>(events);
  }

  // What changes with every event is in registers until the events end or the image is complete.
  template <bool has_times>
  bool take(EventSpan& events) noexcept {
    const SensorFrame frame = frame_;
    const std::size_t pixels = pixels_;
    float* const planes = planes_.data();
    const double weight = weight_;
    const double full =
        config.count > 0 ? static_cast<double>(config.count) : std::numeric_limits<double>::max();
    double filled = filled_;
    std::int64_t last_us = last_us_;
    bool is_complete = false;
    const Event* event = events.data();
    const Event* const end = event + events.size();
    for (; event != end && !is_complete; ++event) {
      if (!frame.contains(*event)) [[unlikely]] {
        ++rejected;
        continue;
      }
      const bool is_plain = last_us <= event->t && event->t < plain_until_us_;
      if (is_plain) [[likely]] {
        last_us = event->t;
      } else if (!place(event->t, filled > 0, last_us)) {
        is_complete = true;
        break;
      }
      const std::size_t pixel = event->y * std::size_t{frame.width()} + event->x;
      const std::size_t plane = pixels & -static_cast<std::size_t>(event->p > 0);  // no branch
      planes[plane + pixel] += static_cast<float>(weight);
      if constexpr (has_times) times_us_[pixel] = moved(last_us, -epoch_us_);
      filled += weight;
      is_complete = filled >= full;
    }
    filled_ = filled;
    last_us_ = last_us;
    events = {event, end};
    if (is_complete) close();
    return is_complete;
  }

  bool has_begun() const noexcept { return filled_ > 0; }

  void close() noexcept {
    // The newest event of an image by count is the last one seen.
    image_begin_us_ = begin_us_;
    image_end_us_ = plus(config.period.count() > 0 ? begin_us_ : last_us_,
                         config.period.count() > 0 ? config.period.count() : 1);
    if (is_plain_) {
      planes_.swap(image_);
    } else {
      float* out = image_.data();
      for (const ImageChannel channel : config.channels) {
        draw(channel, out);
        out += pixels_;
      }
    }
    std::ranges::fill(planes_, 0.0F);
    plain_until_us_ = kEarliest;
    filled_ = 0;
  }

  ImageView image() const noexcept { return {image_, image_begin_us_, image_end_us_}; }

  void set_gamma(double gamma) noexcept { weight_ = 1 / std::max(gamma, kMinGamma); }

  void reset() noexcept {
    std::ranges::fill(planes_, 0.0F);
    std::ranges::fill(image_, 0.0F);
    weight_ = 1;
    filled_ = 0;
    plain_until_us_ = kEarliest;
    last_us_ = kEarliest;
    image_begin_us_ = 0;
    image_end_us_ = 0;
    rejected = 0;
  }

  Config config;
  std::uint64_t rejected = 0;

 private:
  // A timestamp that goes back, is beyond the period or the first of the image. False: its event
  // begins the next one. Epochs as EventClock has them: an image by count has begun as long ago as
  // before.
  bool place(std::int64_t t_us, bool has_begun, std::int64_t& last_us) noexcept {
    const std::int64_t period_us = config.period.count();
    const bool goes_back = t_us < last_us;
    const bool is_epoch = goes_back && begins_epoch(last_us, t_us);
    const auto is_over = [&] {
      return goes_back ? is_epoch
                       : distance_us(begin_us_, t_us) >= static_cast<std::uint64_t>(period_us);
    };
    if (period_us > 0 && has_begun && is_over()) return false;
    if (is_epoch) {
      const std::uint64_t step_us = distance_us(last_us, t_us);
      begin_us_ = moved(begin_us_, step_us);
      epoch_us_ += step_us;
    }
    if (!goes_back || is_epoch) last_us = t_us;
    if (!has_begun) begin_us_ = period_us > 0 ? period_begin(last_us, period_us) : last_us;
    plain_until_us_ = period_us > 0 ? plus(begin_us_, period_us) : kLatest;
    return true;
  }

  void draw(ImageChannel channel, float* out) const noexcept {
    const float* const off = planes_.data();
    const float* const on = off + pixels_;
    switch (channel) {
      case ImageChannel::off:
        std::copy_n(off, pixels_, out);
        return;
      case ImageChannel::on:
        std::copy_n(on, pixels_, out);
        return;
      case ImageChannel::count:
        std::transform(on, on + pixels_, off, out, std::plus<>());
        return;
      case ImageChannel::sum:
        std::transform(on, on + pixels_, off, out, std::minus<>());
        return;
      case ImageChannel::time:
        break;
    }
    // A timestamp stands for the whole microsecond, so an event at the begin differs from none.
    const double duration_us = static_cast<double>(distance_us(image_begin_us_, image_end_us_));
    const std::int64_t begin_us = moved(begin_us_, -epoch_us_);
    for (std::size_t i = 0; i < pixels_; ++i) {
      out[i] = 0.0F;
      if (on[i] == 0 && off[i] == 0) continue;
      const double age_us = static_cast<double>(distance_us(begin_us, times_us_[i])) + 1;
      out[i] = static_cast<float>(std::min(age_us / duration_us, 1.0));
    }
  }

  SensorFrame frame_;
  const std::size_t pixels_;
  const bool is_plain_;                 // the channels are the planes
  std::vector<float> planes_;           // of the image that has begun: OFF, then ON
  std::vector<std::int64_t> times_us_;  // in the first epoch; only for the channel
  std::vector<float> image_;
  double weight_ = 1;
  double filled_ = 0;  // weight of the image that has begun
  std::int64_t begin_us_ = 0;
  std::int64_t plain_until_us_ = kEarliest;  // timestamps in order before it need no look
  std::uint64_t epoch_us_ = 0;               // from the first epoch's timestamps to those of now
  std::int64_t last_us_ = kEarliest;
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
