#include "algorithms/cluster_tracker_config.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <string>

#include "core/check.hpp"

namespace asap {
namespace {

using Config = ClusterTrackerConfig;

// Integers and reals share one table: the range in which the engine's floats stay finite.
struct Parameter {
  ClusterTrackerParameter parameter;
  double min;
  double max;
};

constexpr double kLongest_ms = 60'000;
constexpr double kFarthest_px = 4'096;
constexpr double kMax_events = 60'000;

constexpr Parameter kParameters[] = {
    {{"slots", &Config::slots}, 1, 256},
    {{"cell_px", &Config::cell_px}, 1, 64},
    {{"support_window_ms", &Config::support_window}, 0.001, kLongest_ms},
    {{"tick_ms", &Config::tick}, 0.01, 100},
    {{"warmup_ms", &Config::warmup}, 0.001, kLongest_ms},
    {{"link_ms", &Config::link}, 0.001, kLongest_ms},
    {{"seed_ms", &Config::seed}, 0.001, kLongest_ms},
    {{"mass_ms", &Config::mass}, 0.001, kLongest_ms},
    {{"mean_events", &Config::mean_events}, 1, kMax_events},
    {{"covariance_events", &Config::covariance_events}, 1, kMax_events},
    {{"birth_radius_px", &Config::birth_radius_px}, 0.5, kFarthest_px},
    {{"min_radius_px", &Config::min_radius_px}, 0.5, kFarthest_px},
    {{"max_radius_px", &Config::max_radius_px}, 0.5, kFarthest_px},
    {{"gate_scale", &Config::gate_scale}, 0.01, 100},
    {{"gate_padding_px", &Config::gate_padding_px}, 0.01, kFarthest_px},
    {{"circle_scale", &Config::circle_scale}, 0.01, 100},
    {{"circle_padding_px", &Config::circle_padding_px}, 0.01, kFarthest_px},
    {{"mature_ms", &Config::mature}, 0.001, kLongest_ms},
    {{"contour_events", &Config::contour_events}, 1, 250},
    {{"contour_min_events", &Config::contour_min_events}, 1, 250},
    {{"contour_clip_px", &Config::contour_clip_px}, 0.01, kFarthest_px},
    {{"contour_min_weight", &Config::contour_min_weight}, 0.001, 1},
    {{"contour_weight_scale", &Config::contour_weight_scale}, 0.001, 1'000},
    {{"contact_gain", &Config::contact_gain}, 0.001, 100},
    {{"contact_variance_px2", &Config::contact_variance_px2}, 0.001, 1e6},
    {{"contact_owner_cost", &Config::contact_owner_cost}, 0.001, 1},
    {{"contact_mean_gain", &Config::contact_mean_gain}, 0.001, 1},
    {{"contact_reach", &Config::contact_reach}, 0.001, 100},
    {{"contact_padding_px", &Config::contact_padding_px}, 0.001, kFarthest_px},
    {{"acceleration_px2_s3", &Config::acceleration_px2_s3}, 0.001, 1e12},
    {{"acceleration_per_speed_px", &Config::acceleration_per_speed_px}, 1e-6, 1e6},
    {{"max_acceleration_px2_s3", &Config::max_acceleration_px2_s3}, 0.001, 1e12},
    {{"contact_acceleration_px2_s3", &Config::contact_acceleration_px2_s3}, 0.001, 1e12},
    {{"measurement_scale", &Config::measurement_scale}, 0.001, 1e6},
    {{"min_measurement_px2", &Config::min_measurement_px2}, 1e-6, 1e6},
    {{"seed_events", &Config::seed_events}, 1, kMax_events},
    {{"confirm_events", &Config::confirm_events}, 1, kMax_events},
    {{"die_events", &Config::die_events}, 0.001, kMax_events},
    {{"die_sigma", &Config::die_sigma}, 0.001, 1'000},
    {{"birth_rate_hz", &Config::birth_rate_hz}, 0.001, 1e9},
    {{"confirm_evidence", &Config::confirm_evidence}, 0.001, 25},
    {{"drop_evidence", &Config::drop_evidence}, 0.001, 1'000},
    {{"starve_ratio", &Config::starve_ratio}, 0.001, 1},
    {{"velocity_decay_ms", &Config::velocity_decay}, 0.001, kLongest_ms},
    {{"hide_ms", &Config::hide}, 0.001, kLongest_ms},
    {{"coast_ms", &Config::coast}, 0.001, kLongest_ms},
    {{"merge_reach", &Config::merge_reach}, 0.001, 100},
    {{"merge_padding_px", &Config::merge_padding_px}, 0.001, kFarthest_px},
    {{"merge_tolerance_px", &Config::merge_tolerance_px}, 0.001, kFarthest_px},
    {{"merge_rotation_rad", &Config::merge_rotation_rad}, 0.001, 10},
};

constexpr auto kByName = [] {
  std::array<ClusterTrackerParameter, std::size(kParameters)> parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i] = kParameters[i].parameter;
  return parameters;
}();

// A time counts in the unit that its name in the table tells.
int number_of(int value) { return value; }
double number_of(double value) { return value; }
double number_of(Config::Milliseconds value) { return value.count(); }

std::string range_text(double min, double max) {
  return "must be " + to_text(min) + " to " + to_text(max);
}

template <class Value>
void require_at_most(Value low, Value high, std::string_view field, std::string_view limit) {
  require(low <= high, field, low,
          "must be at most " + std::string(limit) + " = " + to_text(static_cast<double>(high)));
}

}  // namespace

const ClusterTrackerConfig& checked(const ClusterTrackerConfig& config) {
  constexpr int kMaxSide = 16'384;
  const auto is_side = [](int value) { return 1 <= value && value <= kMaxSide; };
  require(is_side(config.width), "width", config.width, "must be 1 to 16384 px");
  require(is_side(config.height), "height", config.height, "must be 1 to 16384 px");

  require_known(config.support, ClusterSupport::kReject, "support");
  for (const auto& limited : kParameters) {  // clang 14 captures no structured binding
    std::visit(
        [&](auto field) {
          const auto value = number_of(config.*field);
          const auto number = static_cast<double>(value);
          require(limited.min <= number && number <= limited.max, limited.parameter.name, value,
                  range_text(limited.min, limited.max));  // false for NaN
        },
        limited.parameter.field);
  }
  require(std::has_single_bit(static_cast<unsigned>(config.cell_px)), "cell_px", config.cell_px,
          "must be a power of two");
  require_at_most(config.min_radius_px, config.birth_radius_px, "min_radius_px", "birth_radius_px");
  require_at_most(config.min_radius_px, config.max_radius_px, "min_radius_px", "max_radius_px");
  require_at_most(config.die_events, config.confirm_events, "die_events", "confirm_events");
  require_at_most(config.contour_min_events, config.contour_events, "contour_min_events",
                  "contour_events");
  require_at_most(config.acceleration_px2_s3, config.max_acceleration_px2_s3, "acceleration_px2_s3",
                  "max_acceleration_px2_s3");
  return config;
}

std::span<const ClusterTrackerParameter> cluster_tracker_parameters() noexcept { return kByName; }

}  // namespace asap
