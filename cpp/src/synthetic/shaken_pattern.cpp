#include "asap/synthetic/streams.hpp"

#include <array>
#include <cmath>
#include <span>

#include "core/check.hpp"
#include "core/random.hpp"
#include "synthetic/block.hpp"
#include "synthetic/outline.hpp"
#include "synthetic/plane.hpp"
#include "synthetic/scene_checks.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kCell_px = 24.0;        // one shape of the print per cell
constexpr double kFirstAmplitude = 0.1;  // share of the last
constexpr double kMinorAxis = 0.8;       // share of the major
constexpr double kMeanSpeed = 0.9028;    // on that ellipse, of the fastest
constexpr double kMaxPatternPixelRate_hz = 500.0;

const ShakenPatternConfig& checked(const ShakenPatternConfig& config) {
  synthetic::require_view_and_time(config.width, config.height, config.duration.count(),
                                   config.start.count());
  const double max_rate_hz = kMaxPatternPixelRate_hz * config.width * config.height;
  require(config.last_rate_hz > 0.0 && config.last_rate_hz <= max_rate_hz, "last_rate_hz",
          config.last_rate_hz, "give a rate above 0, at most 500 events per second and pixel");
  require(config.first_rate_hz > 0.0 && config.first_rate_hz <= config.last_rate_hz,
          "first_rate_hz", config.first_rate_hz, "give a rate above 0, at most last_rate_hz");
  require(config.amplitude_px >= 4.0 && config.amplitude_px <= 1000.0, "amplitude_px",
          config.amplitude_px, "give 4 to 1000 px");
  return config;
}

// The poster reaches beyond the view, so that shaking never uncovers its border.
std::int32_t cells_across(std::int32_t view_px, double amplitude_px) noexcept {
  return static_cast<std::int32_t>((view_px + 2.0 * amplitude_px) / kCell_px) + 2;
}

struct Shape {
  std::size_t vertices;
  double half_tangent;  // tan(pi / vertices)
  double radius_px;
};
constexpr std::array<Shape, 3> kShapes{{
    {.vertices = 24, .half_tangent = 0.13165249758739586, .radius_px = 8.0},  // disk
    {.vertices = 4, .half_tangent = 1.0, .radius_px = 10.0},                  // square
    {.vertices = 3, .half_tangent = 1.7320508075688772, .radius_px = 11.5},   // triangle
}};

void add_shape(Outline& poster, const Shape& shape, double scale, UnitVector first,
               PlanePoint centre) {
  std::array<PlanePoint, 24> vertices{};
  for (std::size_t i = 0; i < shape.vertices; ++i) {
    vertices[i] = {scale * shape.radius_px * first.x, scale * shape.radius_px * first.y};
    first = first.turned(shape.half_tangent);
  }
  poster.add(std::span(vertices).first(shape.vertices), centre);
}

Outline printed_poster(const ShakenPatternConfig& config) {
  const CounterRandom random{CounterRandom(config.seed)(0)};
  Outline poster{CounterRandom{CounterRandom(config.seed)(1)}};
  std::uint64_t drawn = 0;
  const std::int32_t columns = cells_across(config.width, config.amplitude_px);
  const std::int32_t rows = cells_across(config.height, config.amplitude_px);
  for (std::int32_t row = 0; row < rows; ++row) {
    for (std::int32_t column = 0; column < columns; ++column) {
      const Shape& shape = kShapes[random(drawn++) % kShapes.size()];
      const double scale = 0.8 + 0.4 * random.uniform(drawn++);
      const UnitVector first = UnitVector{}.turned(2.0 * random.uniform(drawn++) - 1.0);
      add_shape(poster, shape, scale, first,
                {(column - 0.5) * kCell_px - config.amplitude_px,
                 (row - 0.5) * kCell_px - config.amplitude_px});
    }
  }
  return poster;
}

double events_per_px_in_view(const Outline& poster, const ShakenPatternConfig& config) {
  const double poster_area = kCell_px * cells_across(config.width, config.amplitude_px) * kCell_px *
                             cells_across(config.height, config.amplitude_px);
  const double view_area = static_cast<double>(config.width) * config.height;
  return (poster.events_per_px({1.0, 0.0}) + poster.events_per_px({0.0, 1.0})) / 2.0 * view_area /
         poster_area;
}

}  // namespace

class ShakenPattern::Impl {
 public:
  explicit Impl(const ShakenPatternConfig& config)
      : config_(checked(config)),
        print_(printed_poster(config)),
        noise_(config.width, config.height, config.noise_hz, CounterRandom(config.seed)(2)),
        block_(config.width, config.height, print_.size() + TimeSortedBlock::kMaxStep_us),
        events_per_px_(events_per_px_in_view(print_, config)) {}

  EventSpan next() noexcept {
    while (elapsed_us_ < config_.duration.count()) {
      const std::int32_t step = step_us();
      block_.open(config_.start.count() + elapsed_us_, step);
      noise_.add_to(block_, elapsed_us_);

      const Outline::Place from = place();
      const double angle = speed_px_s() / (kMeanSpeed * amplitude_px()) * 1e-6 * step;
      phase_ = phase_.turned(angle / 2.0);
      elapsed_us_ += step;
      print_.sweep(from, place(), block_);

      const EventSpan events = block_.close();
      if (!events.empty()) return events;
    }
    return {};
  }

 private:
  // 0 at the start, 1 at the end.
  double progress() const noexcept {
    return static_cast<double>(elapsed_us_) / static_cast<double>(config_.duration.count());
  }

  double amplitude_px() const noexcept {
    return config_.amplitude_px * (kFirstAmplitude + (1.0 - kFirstAmplitude) * progress());
  }

  // Mean over the ellipse.
  double speed_px_s() const noexcept {
    const double growth = progress() * std::sqrt(progress());
    const double rate_hz =
        config_.first_rate_hz + (config_.last_rate_hz - config_.first_rate_hz) * growth;
    return rate_hz / events_per_px_;
  }

  Outline::Place place() const noexcept {
    return Outline::place(amplitude_px() * phase_.x, kMinorAxis * amplitude_px() * phase_.y);
  }

  std::int32_t step_us() const noexcept {
    const double growth_px_s =
        1e6 * config_.amplitude_px / static_cast<double>(config_.duration.count());
    return Outline::step_us(speed_px_s() / kMeanSpeed + growth_px_s,
                            config_.duration.count() - elapsed_us_);
  }

  ShakenPatternConfig config_;
  Outline print_;
  BackgroundNoise noise_;
  TimeSortedBlock block_;
  double events_per_px_;
  std::int64_t elapsed_us_ = 0;
  UnitVector phase_;
};

ShakenPattern::ShakenPattern(const ShakenPatternConfig& config)
    : impl_(std::make_unique<Impl>(config)) {}

ShakenPattern::~ShakenPattern() = default;
ShakenPattern::ShakenPattern(ShakenPattern&& other) noexcept = default;
ShakenPattern& ShakenPattern::operator=(ShakenPattern&& other) noexcept = default;

EventSpan ShakenPattern::next() noexcept { return impl_->next(); }

}  // namespace asap::inline v0_1
