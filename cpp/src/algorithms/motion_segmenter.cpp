#include "asap/algorithms/motion_segmenter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "algorithms/motion/background_motion.hpp"
#include "algorithms/motion/motion_regions.hpp"
#include "algorithms/motion/recent_flow.hpp"
#include "algorithms/motion/region_tracks.hpp"
#include "algorithms/smooth_gamma.hpp"
#include "asap/algorithms/plane_flow.hpp"
#include "core/check.hpp"
#include "core/event_clock.hpp"

namespace asap::inline v0_1 {
namespace {

using motion::FlowSample;

constexpr std::int64_t kStep_us = motion::RegionTracks::kStep_us;
constexpr std::int64_t kMemory_us = 15'000;
constexpr float kSlowest_px_s = 5;
constexpr float kFastest_px_s = 3000;

const MotionSegmenterConfig& checked(const MotionSegmenterConfig& config) {
  require(0 <= config.min_px_s && config.min_px_s <= 1e6, "min_px_s", config.min_px_s,
          "must be 0 to 1e6 px/s");
  require(0 <= config.min_share && config.min_share <= 100, "min_share", config.min_share,
          "must be 0 to 100");
  return config;
}

// Flow events of 15 ms: a pixel has one per polarity in a quarter of the window, and edges cover a
// small part of the frame.
std::size_t capacity(const MotionSegmenterConfig& config) {
  const auto pixels =
      static_cast<std::size_t>(config.width) * static_cast<std::size_t>(config.height);
  return std::clamp<std::size_t>(pixels / 4, 1024, 32768);
}

std::int64_t elapsed_us(const EventClock& clock) noexcept {
  return static_cast<std::int64_t>(clock.now_us() - EventClock::kOrigin_us);
}

}  // namespace

// Times count from the first event.
class MotionSegmenter::Impl {
 public:
  explicit Impl(const Config& given)
      : config(checked(given)),
        flow({.width = given.width, .height = given.height, .window = given.window}),
        recent_(capacity(given)),
        background_(given.width, given.height, capacity(given)),
        regions_(given.width, given.height, given.min_px_s, given.min_share) {}

  void process(EventSpan events) noexcept {
    constexpr std::size_t kBlock = 256;
    std::array<Flow, kBlock> flows;
    gamma.take(events.size());
    while (!events.empty()) {
      const EventSpan block = events.first(std::min(kBlock, events.size()));
      const auto flows_of_block = std::span(flows).first(block.size());
      flow.process(block, flows_of_block);
      for (std::size_t i = 0; i < block.size(); ++i) {
        if (block[i].x >= config.width || block[i].y >= config.height) continue;
        advance(block[i].t);
        add(block[i], flows_of_block[i]);
      }
      events = events.subspan(block.size());
    }
  }

  void read(std::int64_t t_us, std::vector<TrackedObject>& objects) const {
    objects.clear();
    if (!clock_.started()) return;
    EventClock clock = clock_;
    clock.advance_to(t_us);
    tracks_.read(objects, elapsed_us(clock) - (next_step_us_ - kStep_us), background_.is_known());
    for (TrackedObject& object : objects) object.t_last = stamp_of(object.t_last);
  }

  void read(std::vector<TrackedObject>& objects) const { read(clock_.latest_us(), objects); }

  std::optional<CameraMotion> camera_motion() const noexcept {
    if (!background_.is_known()) return {};
    const motion::Motion& found = background_.motion();
    const double scale = background_.frame().scale();
    const Eigen::Vector4d units(1, 1, scale, scale);
    CameraMotion told{.t = stamp_of(next_step_us_ - kStep_us),
                      .vx = found[0],
                      .vy = found[1],
                      .turn = found[2] * scale,
                      .zoom = found[3] * scale,
                      .covariance = {}};
    Eigen::Map<Eigen::Matrix4d>(told.covariance.front().data()) =
        units.asDiagonal() * background_.covariance() * units.asDiagonal();
    return told;
  }

  void reset() noexcept {
    flow.reset();
    recent_.clear();
    background_.reset();
    tracks_.clear();
    clock_ = {};
    elapsed_us_ = 0;
    next_step_us_ = kStep_us;
    gamma = {};
  }

  Config config;
  PlaneFlow flow;
  SmoothGamma gamma;

 private:
  void advance(std::int64_t t_us) noexcept {
    clock_.advance(t_us);
    elapsed_us_ = elapsed_us(clock_);
    while (elapsed_us_ >= next_step_us_) step();
  }

  void add(const Event& event, const Flow& found) noexcept {
    if (!(found.vx == found.vx)) return;  // NaN: no flow
    const float speed = std::sqrt(found.vx * found.vx + found.vy * found.vy);
    if (!(kSlowest_px_s < speed && speed < kFastest_px_s)) return;
    recent_.add({.t = elapsed_us_,
                 .x = event.x,
                 .y = event.y,
                 .nx = found.vx / speed,
                 .ny = found.vy / speed,
                 .speed = speed});
  }

  void step() noexcept {
    recent_.forget_before(next_step_us_ - kMemory_us);
    const std::span<const FlowSample> samples = recent_.samples();
    const bool is_known = background_.fit(samples, gamma.value());
    tracks_.step(is_known ? regions_.find(samples, background_)
                          : std::span<const motion::Region>{});
    // Nothing happens in the rest of a long silence.
    const bool is_silent = samples.empty() && tracks_.empty();
    next_step_us_ = is_silent ? (elapsed_us_ / kStep_us + 1) * kStep_us : next_step_us_ + kStep_us;
  }

  std::int64_t stamp_of(std::int64_t then_us) const noexcept {
    return clock_.stamp_us(elapsed_us_ - then_us);
  }

  motion::RecentFlow recent_;
  motion::BackgroundMotion background_;
  motion::MotionRegions regions_;
  motion::RegionTracks tracks_;
  EventClock clock_;
  std::int64_t elapsed_us_ = 0;
  std::int64_t next_step_us_ = kStep_us;
};

MotionSegmenter::MotionSegmenter(const Config& config) : impl_(std::make_unique<Impl>(config)) {}
MotionSegmenter::~MotionSegmenter() = default;
MotionSegmenter::MotionSegmenter(MotionSegmenter&&) noexcept = default;
MotionSegmenter& MotionSegmenter::operator=(MotionSegmenter&&) noexcept = default;

void MotionSegmenter::process(EventSpan events) noexcept { impl_->process(events); }

std::vector<TrackedObject> MotionSegmenter::objects() const {
  std::vector<TrackedObject> read;
  objects(read);
  return read;
}

void MotionSegmenter::objects(std::vector<TrackedObject>& objects) const { impl_->read(objects); }

std::vector<TrackedObject> MotionSegmenter::objects_at(std::int64_t t_us) const {
  std::vector<TrackedObject> read;
  objects_at(t_us, read);
  return read;
}

void MotionSegmenter::objects_at(std::int64_t t_us, std::vector<TrackedObject>& objects) const {
  impl_->read(t_us, objects);
}

std::optional<CameraMotion> MotionSegmenter::camera_motion() const noexcept {
  return impl_->camera_motion();
}

void MotionSegmenter::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  impl_->gamma.tell(gamma);
}

void MotionSegmenter::reset() noexcept { impl_->reset(); }

std::uint64_t MotionSegmenter::rejected() const noexcept { return impl_->flow.rejected(); }

const MotionSegmenter::Config& MotionSegmenter::config() const noexcept { return impl_->config; }

}  // namespace asap::inline v0_1
