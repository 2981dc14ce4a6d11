// The parameters of ClusterTracker by name, with their ranges, and the check of a configuration.
// Any thread, no allocation but for an error.
#pragma once

#include <span>
#include <string_view>
#include <variant>

#include "asap/algorithms/cluster_tracker.hpp"

namespace asap {

// Returns its argument; throws std::invalid_argument that names the first bad field.
const ClusterTrackerConfig& checked(const ClusterTrackerConfig& config);

// A parameter by name, so that bindings can set, list and check all without naming each.
struct ClusterTrackerParameter {
  std::string_view name;
  std::variant<int ClusterTrackerConfig::*, double ClusterTrackerConfig::*,
               ClusterTrackerConfig::Milliseconds ClusterTrackerConfig::*>
      field;
};

// All but width, height and support, in the order above.
std::span<const ClusterTrackerParameter> cluster_tracker_parameters() noexcept;

}  // namespace asap
