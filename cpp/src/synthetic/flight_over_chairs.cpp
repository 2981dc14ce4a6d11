#include "asap/synthetic/streams.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/check.hpp"
#include "core/random.hpp"
#include "synthetic/block.hpp"
#include "synthetic/outline.hpp"
#include "synthetic/plane.hpp"
#include "synthetic/scene_checks.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLane = 1.4;         // distance of two chairs of a row, in chair widths
constexpr double kRowPitch = 1.9;     // distance of two rows; a chair stays inside
constexpr double kFirstSpeed = 0.15;  // share of the last
constexpr double kMaxTilt = 0.12;     // tangent of half the angle
constexpr double kSwaySpeed = 0.08;   // the fastest, of the last speed
constexpr double kSway_hz = 0.7;
constexpr double kMaxFlightPixelRate_hz = 100.0;

// A chair from the front and above, one wide: back, posts, seat, four legs; clockwise as seen.
using Part = std::array<PlanePoint, 4>;
constexpr Part box(double left, double top, double right, double bottom) {
  return {{{left, top}, {right, top}, {right, bottom}, {left, bottom}}};
}
constexpr std::array<Part, 8> kChair{{
    box(-0.40, 0.00, 0.40, 0.40),                                  // back
    box(-0.36, 0.40, -0.28, 0.56),                                 // posts
    box(0.28, 0.40, 0.36, 0.56),                                   //
    {{{-0.40, 0.56}, {0.40, 0.56}, {0.50, 0.84}, {-0.50, 0.84}}},  // seat
    box(-0.48, 0.84, -0.39, 1.42),                                 // front legs
    box(0.39, 0.84, 0.48, 1.42),                                   //
    box(-0.30, 0.84, -0.23, 1.18),                                 // rear legs
    box(0.23, 0.84, 0.30, 1.18),                                   //
}};

void add_chair(Outline& outline, double width_px, UnitVector tilt, PlanePoint top) {
  for (const Part& part : kChair) {
    Part placed{};
    for (std::size_t i = 0; i < part.size(); ++i) {
      const double x = part[i].x * width_px;
      const double y = part[i].y * width_px;
      placed[i] = {x * tilt.x - y * tilt.y, x * tilt.y + y * tilt.x};
    }
    outline.add(placed, top);
  }
}

const FlightOverChairsConfig& checked(const FlightOverChairsConfig& config) {
  synthetic::require_view_and_time(config.width, config.height, config.duration.count(),
                                   config.start.count());
  const double max_rate_hz = kMaxFlightPixelRate_hz * config.width * config.height;
  require(config.last_rate_hz > 0.0 && config.last_rate_hz <= max_rate_hz, "last_rate_hz",
          config.last_rate_hz, "give a rate above 0, at most 100 events per second and pixel");
  require(config.chair_px >= 8.0 && config.chair_px <= config.width / 2.0, "chair_px",
          config.chair_px, "give 8 px to half the sensor's width");
  return config;
}

std::int32_t lanes_of(const FlightOverChairsConfig& config) {
  return static_cast<std::int32_t>(config.width / (kLane * config.chair_px));
}

double events_per_px_of_chair(double width_px) {
  Outline chair{CounterRandom{0}};
  add_chair(chair, width_px, UnitVector{}.turned(kMaxTilt / 2.0), {});
  return chair.events_per_px({0.0, 1.0});
}

// A full floor in view releases last_rate_hz at this speed.
double speed_over_full_floor_px_s(const FlightOverChairsConfig& config) {
  const double rows_in_view = config.height / (kRowPitch * config.chair_px);
  const double chairs_in_view = lanes_of(config) * rows_in_view;
  return config.last_rate_hz / (chairs_in_view * events_per_px_of_chair(config.chair_px));
}

std::size_t max_points_per_row(const FlightOverChairsConfig& config) {
  constexpr std::size_t kRoundedUp = 4 * kChair.size();
  Outline chair{CounterRandom{0}};
  add_chair(chair, config.chair_px, {}, {});
  return static_cast<std::size_t>(lanes_of(config)) * (chair.size() + kRoundedUp);
}

std::vector<Outline> empty_rows(const FlightOverChairsConfig& config) {
  const CounterRandom seeds{CounterRandom(config.seed)(0)};
  const auto count = static_cast<std::size_t>(config.height / (kRowPitch * config.chair_px)) + 2;
  std::vector<Outline> rows;
  for (std::size_t i = 0; i < count; ++i) {
    rows.emplace_back(CounterRandom{seeds(i)}).reserve(max_points_per_row(config));
  }
  return rows;
}

}  // namespace

class FlightOverChairs::Impl {
 public:
  explicit Impl(const FlightOverChairsConfig& config)
      : config_(checked(config)),
        lanes_(lanes_of(config)),
        row_pitch_px_(kRowPitch * config.chair_px),
        last_speed_px_s_(speed_over_full_floor_px_s(config)),
        first_full_row_(std::max(1.0, flown_px(config.duration.count()) / row_pitch_px_)),
        layout_(CounterRandom(config.seed)(1)),
        noise_(config.width, config.height, config.noise_hz, CounterRandom(config.seed)(2)),
        rows_(empty_rows(config)),
        block_(config.width, config.height,
               rows_.size() * max_points_per_row(config) + TimeSortedBlock::kMaxStep_us) {
    for (std::size_t row = 0; row < rows_.size(); ++row) fill(static_cast<std::int64_t>(row));
  }

  EventSpan next() noexcept {
    while (elapsed_us_ < config_.duration.count()) {
      const std::int32_t step = step_us();
      block_.open(config_.start.count() + elapsed_us_, step);
      noise_.add_to(block_, elapsed_us_);

      const View from = view();
      sway_ = sway_.turned(kPi * kSway_hz * 1e-6 * step);
      elapsed_us_ += step;
      sweep(from, view());

      const EventSpan events = block_.close();
      if (!events.empty()) return events;
    }
    return {};
  }

 private:
  struct View {
    double flown_px;
    double sway_px;
  };

  void sweep(View from, View to) noexcept {
    const auto rows = static_cast<std::int64_t>(rows_.size());
    for (std::int64_t row = nearest_row_; row < nearest_row_ + rows; ++row) {
      outline_of(row).sweep(place_of(row, from), place_of(row, to), block_);
    }
    if (place_of(nearest_row_, to).y < config_.height * Outline::kUnit) return;
    fill(nearest_row_ + rows);  // takes the memory of the row that left at the bottom
    ++nearest_row_;
  }

  void fill(std::int64_t row) noexcept {
    Outline& outline = outline_of(row);
    outline.clear();
    const CounterRandom random{layout_(static_cast<std::uint64_t>(row))};
    std::uint64_t drawn = 0;
    const double lane_px = static_cast<double>(config_.width) / lanes_;
    const auto before = static_cast<std::int64_t>(chairs_before(row));
    const auto after = static_cast<std::int64_t>(chairs_before(row + 1));
    std::int64_t chairs = std::min<std::int64_t>(after - before, lanes_);
    for (std::int32_t lane = 0; lane < lanes_; ++lane) {
      // Each lane that is left is equally likely to get one of the chairs that are left.
      if (random.uniform(drawn++) * (lanes_ - lane) >= static_cast<double>(chairs)) continue;
      --chairs;
      const UnitVector tilt = UnitVector{}.turned(kMaxTilt * (2.0 * random.uniform(drawn++) - 1.0));
      const double shift_x = 0.2 * random.uniform(drawn++) - 0.1;
      const double shift_y = 0.15 + 0.2 * random.uniform(drawn++);
      add_chair(outline, config_.chair_px, tilt,
                {(lane + 0.5) * lane_px + shift_x * config_.chair_px, shift_y * config_.chair_px});
    }
  }

  // Chairs per row grow from none to all lanes at first_full_row_: the integral of that growth.
  double chairs_before(std::int64_t row) const noexcept {
    const double beyond = std::max(0.0, static_cast<double>(row) - first_full_row_);
    const double share = std::min(1.0, static_cast<double>(row) / first_full_row_);
    const double growing = share * share * (1.0 / 4.0 + share / 6.0);
    return lanes_ * (first_full_row_ * growing + beyond);
  }

  Outline& outline_of(std::int64_t row) noexcept {
    return rows_[static_cast<std::size_t>(row) % rows_.size()];
  }

  View view() const noexcept {
    const double sway_reach_px = kSwaySpeed * last_speed_px_s_ / (2.0 * kPi * kSway_hz);
    return {.flown_px = flown_px(elapsed_us_), .sway_px = sway_reach_px * sway_.y};
  }

  Outline::Place place_of(std::int64_t row, View view) const noexcept {
    const double ahead_px = static_cast<double>(row + 1) * row_pitch_px_;
    return Outline::place(view.sway_px, config_.height + view.flown_px - ahead_px);
  }

  double flown_px(std::int64_t elapsed_us) const noexcept {
    const double seconds = 1e-6 * static_cast<double>(elapsed_us);
    const double progress =
        static_cast<double>(elapsed_us) / static_cast<double>(config_.duration.count());
    return last_speed_px_s_ * seconds * (kFirstSpeed + (1.0 - kFirstSpeed) / 2.0 * progress);
  }

  std::int32_t step_us() const noexcept {
    return Outline::step_us((1.0 + kSwaySpeed) * last_speed_px_s_,
                            config_.duration.count() - elapsed_us_);
  }

  FlightOverChairsConfig config_;
  std::int32_t lanes_;
  double row_pitch_px_;
  double last_speed_px_s_;
  double first_full_row_;
  CounterRandom layout_;
  BackgroundNoise noise_;
  std::vector<Outline> rows_;  // row r in slot r modulo size, from nearest_row_ on
  TimeSortedBlock block_;
  std::int64_t nearest_row_ = 0;
  std::int64_t elapsed_us_ = 0;
  UnitVector sway_;
};

FlightOverChairs::FlightOverChairs(const FlightOverChairsConfig& config)
    : impl_(std::make_unique<Impl>(config)) {}

FlightOverChairs::~FlightOverChairs() = default;
FlightOverChairs::FlightOverChairs(FlightOverChairs&& other) noexcept = default;
FlightOverChairs& FlightOverChairs::operator=(FlightOverChairs&& other) noexcept = default;

EventSpan FlightOverChairs::next() noexcept { return impl_->next(); }

}  // namespace asap::inline v0_1
