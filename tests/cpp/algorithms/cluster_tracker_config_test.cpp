#include "algorithms/cluster_tracker_config.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace cluster_tracker_config_test {
namespace {

using asap::ClusterTrackerConfig;

std::string complaint(const std::function<void(ClusterTrackerConfig&)>& spoil) {
  ClusterTrackerConfig config{.width = 346, .height = 260};
  spoil(config);
  try {
    asap::checked(config);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(ClusterTrackerConfig, DefaultsAreAllowed) {
  EXPECT_EQ(complaint([](auto&) {}), "");
}

TEST(ClusterTrackerConfig, EveryParameterRefusesWhatIsNoPositiveNumber) {
  for (const auto& parameter : asap::cluster_tracker_parameters()) {
    const std::string name(parameter.name);
    std::visit(
        [&](auto field) {
          using Value =
              std::remove_reference_t<decltype(std::declval<ClusterTrackerConfig>().*field)>;
          using Number = std::conditional_t<std::is_same_v<Value, int>, int, double>;
          std::vector<Number> bad{0, -1, std::numeric_limits<Number>::max()};
          if constexpr (std::is_same_v<Number, double>) {
            bad.push_back(std::numeric_limits<double>::quiet_NaN());
            bad.push_back(std::numeric_limits<double>::infinity());
          }
          for (const Number value : bad) {
            const auto text = complaint([&](auto& config) { config.*field = Value(value); });
            EXPECT_TRUE(text.starts_with(name + " = ")) << name << ' ' << value << ": " << text;
            EXPECT_NE(text.find("must be "), std::string::npos) << text;
          }
        },
        parameter.field);
  }
}

TEST(ClusterTrackerConfig, NamesAreUniqueAndFieldsDiffer) {
  std::set<std::string_view> names;
  for (const auto& parameter : asap::cluster_tracker_parameters()) {
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
    ClusterTrackerConfig config{.width = 1, .height = 1};
    const auto is_77 = [&](auto field) {
      return config.*field == std::decay_t<decltype(config.*field)>(77);
    };
    std::visit([&](auto field) { config.*field = std::decay_t<decltype(config.*field)>(77); },
               parameter.field);
    int changed = 0;
    for (const auto& other : asap::cluster_tracker_parameters()) {
      changed += std::visit(is_77, other.field);
    }
    EXPECT_EQ(changed, 1) << parameter.name;
  }
}

TEST(ClusterTrackerConfig, OrderIsChecked) {
  EXPECT_EQ(complaint([](auto& c) { c.min_radius_px = 19; }),
            "min_radius_px = 19: must be at most birth_radius_px = 18");
  EXPECT_EQ(complaint([](auto& c) { c.max_radius_px = 6; }),
            "min_radius_px = 7: must be at most max_radius_px = 6");
  EXPECT_EQ(complaint([](auto& c) { c.die_events = 15; }),
            "die_events = 15: must be at most confirm_events = 14");
  EXPECT_EQ(complaint([](auto& c) { c.contour_min_events = 17; }),
            "contour_min_events = 17: must be at most contour_events = 16");
  EXPECT_NE(complaint([](auto& c) { c.acceleration_px2_s3 = 1e8; }), "");
}

TEST(ClusterTrackerConfig, FrameAndCellsAreChecked) {
  EXPECT_EQ(complaint([](auto& c) { c.width = 0; }), "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(complaint([](auto& c) { c.height = 16385; }), "height = 16385: must be 1 to 16384 px");
  EXPECT_EQ(complaint([](auto& c) { c.cell_px = 6; }), "cell_px = 6: must be a power of two");
}

}  // namespace
}  // namespace cluster_tracker_config_test
