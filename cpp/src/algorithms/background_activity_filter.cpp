#include "asap/algorithms/noise_filters.hpp"

#include "algorithms/int4.hpp"
#include "algorithms/recent_times.hpp"
#include "algorithms/sensor_frame.hpp"
#include "algorithms/smooth_gamma.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

using Time = RecentTimes::Time;

const BackgroundActivityFilterConfig& checked(const BackgroundActivityFilterConfig& config) {
  require(0 <= config.window.count() && config.window.count() <= RecentTimes::kMaxWindow_us,
          "window_us", config.window.count(), "must be 0 to 500000000 us");
  return config;
}

// Whether a neighbour fired at `oldest` or later. Reads four pixels of a row where three are meant.
bool is_supported(const Time* own, std::ptrdiff_t stride, Time oldest) noexcept {
  const auto young = [&](const Time* row) {
    return Int4::mask_above(Int4::load(row - 1), oldest - 1);
  };
  const std::uint32_t outer = young(own - stride) | young(own + stride);
  return ((outer & 0b111) | (young(own) & 0b101)) != 0;
}

}  // namespace

class BackgroundActivityFilter::Impl {
 public:
  explicit Impl(const Config& given)
      : config(checked(given)),
        frame_(config.width, config.height),
        stride_(frame_.width() + 2),
        window_us_(static_cast<Time>(config.window.count())),
        times_(stride_ * (frame_.height() + 2) + 1, RecentTimes::kLongAgo) {}

  bool update(const Event& event) noexcept {
    if (!frame_.contains(event)) [[unlikely]] {
      ++rejected;
      return false;
    }
    const Time now = times_.time_of(event.t);
    Time* own = times_.data() + (event.y + 1U) * stride_ + event.x + 1;
    const bool passes = is_supported(own, static_cast<std::ptrdiff_t>(stride_), now - window_us_);
    *own = now;
    return passes;
  }

  // So many events come now.
  void begin(std::size_t events) noexcept {
    if (!gamma.take(events)) return;
    constexpr auto kLongest = static_cast<double>(RecentTimes::kMaxWindow_us);
    const auto window = static_cast<double>(config.window.count());
    const double kept = gamma.value();
    window_us_ = static_cast<Time>(window < kLongest * kept ? window / kept : kLongest);
  }

  void reset() noexcept {
    times_.clear();
    window_us_ = static_cast<Time>(config.window.count());
    gamma = {};
    rejected = 0;
  }

  Config config;
  SmoothGamma gamma;
  std::uint64_t rejected = 0;

 private:
  SensorFrame frame_;
  std::size_t stride_;
  Time window_us_;
  RecentTimes times_;  // a border of one pixel lies around the frame
};

BackgroundActivityFilter::BackgroundActivityFilter(const Config& config)
    : impl_(std::make_unique<Impl>(config)) {}
BackgroundActivityFilter::~BackgroundActivityFilter() = default;
BackgroundActivityFilter::BackgroundActivityFilter(const BackgroundActivityFilter& other)
    : impl_(std::make_unique<Impl>(*other.impl_)) {}
BackgroundActivityFilter& BackgroundActivityFilter::operator=(
    const BackgroundActivityFilter& other) {
  return *this = BackgroundActivityFilter(other);
}
BackgroundActivityFilter::BackgroundActivityFilter(BackgroundActivityFilter&&) noexcept = default;
BackgroundActivityFilter& BackgroundActivityFilter::operator=(BackgroundActivityFilter&&) noexcept =
    default;

std::size_t BackgroundActivityFilter::process(EventSpan events, std::span<Event> out) noexcept {
  Impl& impl = *impl_;
  impl.begin(events.size());
  std::size_t passed = 0;
  for (const Event event : events) {
    const bool passes = impl.update(event);
    out[passed] = event;
    passed += passes;
  }
  return passed;
}

void BackgroundActivityFilter::process(EventSpan events, std::span<Answer> passes,
                                       std::size_t package) {
  require(passes.size() == events.size(), "passes.size()", passes.size(),
          "must be the number of events");
  impl_->begin(package);
  for (std::size_t i = 0; i < events.size(); ++i) passes[i] = impl_->update(events[i]);
}

void BackgroundActivityFilter::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  impl_->gamma.tell(gamma);
}

void BackgroundActivityFilter::reset() noexcept { impl_->reset(); }

std::uint64_t BackgroundActivityFilter::rejected() const noexcept { return impl_->rejected; }

const BackgroundActivityFilter::Config& BackgroundActivityFilter::config() const noexcept {
  return impl_->config;
}

}  // namespace asap::inline v0_1
