#include "asap/algorithms/plane_flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_surfaces.hpp"

namespace plane_flow_test {
namespace {

using std::chrono::microseconds;

using asap::Event;
using asap::Flow;
using asap::PlaneFlow;
using Events = std::vector<Event>;
using Flows = std::vector<Flow>;

Flows flows_of(PlaneFlow& flow, const Events& events) {
  Flows flows(events.size(), Flow{.vx = 7, .vy = 7});
  const std::size_t with_flow = flow.process(events, flows);
  const auto found =
      std::count_if(flows.begin(), flows.end(), [](const Flow& f) { return !std::isnan(f.vx); });
  EXPECT_EQ(with_flow, static_cast<std::size_t>(found));
  return flows;
}

constexpr std::array<std::optional<bool>, 3> kRules{std::nullopt, true, false};

// A straight edge that sweeps the frame: pixel (x, y) fires at x sx + y sy us.
Events edge(int sx, int sy, std::int16_t p = 1) {
  Events events;
  for (std::uint16_t y = 0; y < 30; ++y) {
    for (std::uint16_t x = 0; x < 40; ++x) {
      events.push_back({.x = x, .y = y, .p = p, .t = 1'000'000 + sx * x + sy * y});
    }
  }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
    return std::tie(a.t, a.y, a.x) < std::tie(b.t, b.y, b.x);
  });
  return events;
}

TEST(PlaneFlow, IsTheVelocityOfAnEdge) {
  for (const auto& [sx, sy] : {std::pair{400, 300}, {-1000, 0}, {0, 250}, {120, -50}}) {
    for (const auto refit : kRules) {
      PlaneFlow flow({.width = 40, .height = 30, .refit = refit});
      const Events events = edge(sx, sy);
      const Flows flows = flows_of(flow, events);
      const double squared = sx * sx + sy * sy;
      std::size_t found = 0;
      for (const Flow& f : flows) {
        if (std::isnan(f.vx)) continue;
        ++found;
        ASSERT_NEAR(f.vx, 1e6 * sx / squared, 0.01);
        ASSERT_NEAR(f.vy, 1e6 * sy / squared, 0.01);
      }
      EXPECT_GT(found, events.size() * 8 / 10);
    }
  }
}

TEST(PlaneFlow, AgreesWithTheDefinition) {
  for (const auto& wild : asap::test::wild_streams()) {
    const Events events = asap::test::wild_stream(wild, 20'000);
    for (const auto refit : kRules) {
      for (const std::int64_t window_us : {3'000, 40'000, 10'000'000}) {
        const int min = window_us == 3'000 ? 6 : 7;
        PlaneFlow flow({.width = wild.width,
                        .height = wild.height,
                        .window = microseconds(window_us),
                        .min_points = min,
                        .refit = refit});
        asap::test::NaivePlaneFlow naive(wild.width, wild.height, window_us,
                                         static_cast<std::size_t>(min), refit);
        const Flows flows = flows_of(flow, events);
        std::size_t found = 0;
        for (std::size_t i = 0; i < events.size(); ++i) {
          const auto expected = naive.update(events[i]);
          ASSERT_EQ(std::isnan(flows[i].vx), !expected) << wild.seed << ' ' << i;
          if (!expected) continue;
          ++found;
          const double tolerance = 1e-5 * std::hypot(expected->vx, expected->vy);
          ASSERT_NEAR(flows[i].vx, expected->vx, tolerance) << wild.seed << ' ' << i;
          ASSERT_NEAR(flows[i].vy, expected->vy, tolerance) << wild.seed << ' ' << i;
        }
        if (wild.width == 40) {
          EXPECT_GT(found, 300U) << wild.seed << ' ' << window_us << ' ' << refit.has_value();
        }
      }
    }
  }
}

// As `events`, each followed by a second one at its pixel, so much later.
Events with_echoes(const Events& events, std::int64_t later_us, std::int16_t p = 1) {
  Events all = events;
  for (Event event : events) {
    event.t += later_us;
    event.p = p;
    all.push_back(event);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Event& a, const Event& b) { return a.t < b.t; });
  return all;
}

TEST(PlaneFlow, OnlyTheFirstEventsOfABurstCount) {
  const Events events = edge(400, 300);
  PlaneFlow alone({.width = 40, .height = 30});
  const std::size_t expected = alone.process(events);
  PlaneFlow burst({.width = 40, .height = 30});
  EXPECT_EQ(burst.process(with_echoes(events, 10'000)), expected);
  PlaneFlow apart({.width = 40, .height = 30});
  EXPECT_GT(apart.process(with_echoes(events, 10'001)), expected);
  PlaneFlow published({.width = 40, .height = 30, .refit = true});
  EXPECT_GT(published.process(with_echoes(events, 10'000)), expected);
}

TEST(PlaneFlow, EventsOnALineHaveNone) {
  for (const auto refit : kRules) {
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}}) {
      Events events;
      for (int i = 0; i < 20; ++i) {
        events.push_back({.x = static_cast<std::uint16_t>(10 + i * dx),
                          .y = static_cast<std::uint16_t>(5 + i * dy),
                          .p = 1,
                          .t = 1000 * i});
      }
      PlaneFlow flow({.width = 40, .height = 30, .min_points = 4, .refit = refit});
      EXPECT_EQ(flow.process(events), 0U) << dx << dy;
    }
  }
}

}  // namespace
}  // namespace plane_flow_test
