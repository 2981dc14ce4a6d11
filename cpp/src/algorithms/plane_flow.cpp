#include "asap/algorithms/plane_flow.hpp"

#include <utility>

#include "algorithms/plane_fit.hpp"
#include "algorithms/recent_times.hpp"
#include "algorithms/sensor_frame.hpp"
#include "algorithms/trimmed_plane_fit.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr std::size_t kBorder = TrimmedPlaneFit::kReach;
constexpr std::int64_t kBurstsPerWindow = 4;

const PlaneFlowConfig& checked(const PlaneFlowConfig& config) {
  require(1 <= config.window.count() && config.window.count() <= PlaneFit::kMaxWindow_us,
          "window_us", config.window.count(), "must be 1 to 10000000 us");
  require(3 <= config.min_points && config.min_points <= 25, "min_points", config.min_points,
          "must be 3 to 25 px");
  return config;
}

// A plane this flat tells no velocity: faster than 1000 px in 1 us.
bool is_flat(double squared_slope) noexcept { return squared_slope < 1e-6; }

}  // namespace

class PlaneFlow::Impl {
 public:
  explicit Impl(const Config& given)
      : config(checked(given)),
        frame_(config.width, config.height),
        stride_(frame_.width() + 2 * kBorder),
        plane_(stride_ * (frame_.height() + 2 * kBorder)),
        burst_us_(static_cast<Time>(config.window.count() / kBurstsPerWindow)),
        times_((config.refit ? 2 : 4) * plane_ + PlaneFit::kLanes, RecentTimes::kLongAgo) {}

  // Takes the event; `flow` may be none.
  bool update(const Event& event, Flow* flow) noexcept {
    if (!frame_.contains(event)) [[unlikely]] {
      ++rejected;
      return false;
    }
    const Time now = times_.time_of(event.t);
    Time* const own = times_.data() + (event.p > 0 ? plane_ : 0) + (event.y + kBorder) * stride_ +
                      event.x + kBorder;
    if (!config.refit && burst_goes_on(now, own)) return false;
    *own = now;
    TimePlane plane;
    if (flow == nullptr || !(config.refit ? fit_as_published(own, plane) : fit(own, plane))) {
      return false;
    }
    const double squared_slope = plane.a * plane.a + plane.b * plane.b;
    if (is_flat(squared_slope)) return false;
    constexpr double kUsPerS = 1e6;
    flow->vx = static_cast<float>(kUsPerS * plane.a / squared_slope);
    flow->vy = static_cast<float>(kUsPerS * plane.b / squared_slope);
    return true;
  }

  void reset() noexcept {
    times_.clear();
    rejected = 0;
  }

  Config config;
  std::uint64_t rejected = 0;

 private:
  using Time = RecentTimes::Time;

  bool burst_goes_on(Time now, Time* own) noexcept {
    return std::exchange(own[2 * plane_], now) >= now - burst_us_;
  }

  bool fit(const Time* own, TimePlane& plane) const noexcept {
    TrimmedPlaneFit fit(own, static_cast<std::ptrdiff_t>(stride_),
                        static_cast<Time>(config.window.count()));
    return fit.fit(static_cast<std::size_t>(config.min_points), plane);
  }

  bool fit_as_published(const Time* own, TimePlane& plane) const noexcept {
    PlaneFit fit(own, static_cast<std::ptrdiff_t>(stride_),
                 static_cast<Time>(config.window.count()));
    if (fit.points() < config.min_points || !fit.fit(plane)) return false;
    if (!*config.refit || fit.drop_outliers(plane) == 0) return true;
    return fit.points() >= config.min_points && fit.fit(plane);
  }

  SensorFrame frame_;
  std::size_t stride_;
  std::size_t plane_;
  Time burst_us_;
  // A plane per polarity, with a border around the frame. If `refit` is not set, of the first
  // events of a burst; then follow two of the latest events.
  RecentTimes times_;
};

PlaneFlow::PlaneFlow(const Config& config) : impl_(std::make_unique<Impl>(config)) {}
PlaneFlow::~PlaneFlow() = default;
PlaneFlow::PlaneFlow(const PlaneFlow& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
PlaneFlow& PlaneFlow::operator=(const PlaneFlow& other) { return *this = PlaneFlow(other); }
PlaneFlow::PlaneFlow(PlaneFlow&&) noexcept = default;
PlaneFlow& PlaneFlow::operator=(PlaneFlow&&) noexcept = default;

std::size_t PlaneFlow::process(EventSpan events) noexcept {
  Impl& impl = *impl_;
  std::size_t with_flow = 0;
  for (const Event& event : events) {
    Flow flow;
    with_flow += impl.update(event, &flow);
  }
  return with_flow;
}

std::size_t PlaneFlow::process(EventSpan events, std::span<Flow> flows) {
  require(flows.size() == events.size(), "flows.size()", flows.size(),
          "must be the number of events");
  Impl& impl = *impl_;
  std::size_t with_flow = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    flows[i] = {};
    with_flow += impl.update(events[i], &flows[i]);
  }
  return with_flow;
}

void PlaneFlow::process(EventSpan events, std::span<Flow> flows,
                        const std::uint32_t* places) noexcept {
  Impl& impl = *impl_;
  for (std::size_t i = 0; i < events.size(); ++i) {
    impl.update(events[i], places[i] < flows.size() ? &flows[places[i]] : nullptr);
  }
}

void PlaneFlow::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

void PlaneFlow::reset() noexcept { impl_->reset(); }

std::uint64_t PlaneFlow::rejected() const noexcept { return impl_->rejected; }

const PlaneFlow::Config& PlaneFlow::config() const noexcept { return impl_->config; }

}  // namespace asap::inline v0_1
