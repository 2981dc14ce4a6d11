#include "asap/algorithms/plane_flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_surfaces.hpp"
#include "support/allocation_counter.hpp"
#include "support/errors.hpp"

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

bool same(const Flow& a, const Flow& b) {
  const auto equal = [](float u, float v) { return u == v || (std::isnan(u) && std::isnan(v)); };
  return equal(a.vx, b.vx) && equal(a.vy, b.vy);
}

bool same(const Flows& a, const Flows& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Flow& u, const Flow& v) { return same(u, v); });
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

TEST(PlaneFlow, PolaritiesAreApart) {
  Events mixed = edge(400, 300);
  for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i].p = i % 2 == 0;
  Events on;
  for (const Event& event : mixed) {
    if (event.p > 0) on.push_back(event);
  }
  PlaneFlow both({.width = 40, .height = 30});
  PlaneFlow alone({.width = 40, .height = 30});
  const Flows all = flows_of(both, mixed);
  Flows of_on;
  for (std::size_t i = 0; i < mixed.size(); i += 2) of_on.push_back(all[i]);
  EXPECT_TRUE(same(of_on, flows_of(alone, on)));
}

TEST(PlaneFlow, NeedsEnoughPoints) {
  const Events events{{.x = 9, .y = 8, .p = 1, .t = 0},
                      {.x = 8, .y = 9, .p = 1, .t = 40},
                      {.x = 11, .y = 9, .p = 1, .t = 100},
                      {.x = 10, .y = 10, .p = 1, .t = 140}};
  for (const auto refit : kRules) {
    for (const int min : {4, 5}) {
      PlaneFlow flow({.width = 40, .height = 30, .min_points = min, .refit = refit});
      EXPECT_EQ(std::isnan(flows_of(flow, events).back().vx), min == 5);
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

TEST(PlaneFlow, ABurstIsAQuarterOfTheWindow) {
  const Events events = edge(400, 300);
  PlaneFlow flow({.width = 40, .height = 30, .window = microseconds(80'000)});
  const std::size_t expected = flow.process(events);
  flow.reset();
  EXPECT_EQ(flow.process(with_echoes(events, 20'000)), expected);
  flow.reset();
  EXPECT_GT(flow.process(with_echoes(events, 20'001)), expected);
}

TEST(PlaneFlow, ABurstIsOfOnePolarity) {
  PlaneFlow flow({.width = 40, .height = 30});
  const std::size_t expected = flow.process(edge(400, 300));
  flow.reset();
  EXPECT_EQ(flow.process(with_echoes(edge(400, 300), 1, 0)), 2 * expected);
}

TEST(PlaneFlow, ABurstLastsAsLongAsItsEvents) {
  // Every 6 ms an event at each pixel: only the first has no other within 10 ms before.
  Events events = edge(4, 3);
  PlaneFlow flow({.width = 40, .height = 30});
  EXPECT_GT(flow.process(events), 1'000U);
  for (int i = 0; i < 5; ++i) {
    for (Event& event : events) event.t += 6'000;
    EXPECT_EQ(flow.process(events), 0U);
  }
}

TEST(PlaneFlow, SimultaneousEventsHaveNone) {
  PlaneFlow flow({.width = 40, .height = 30});
  EXPECT_EQ(flow.process(edge(0, 0)), 0U);
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

TEST(PlaneFlow, ResetIsANewFlow) {
  const Events events = asap::test::golden_corner_stream(20'000);
  PlaneFlow flow({.width = 346, .height = 260});
  const Flows expected = flows_of(flow, events);
  const Events outside{{.x = 346, .y = 0, .p = 0, .t = 1 << 30}};
  flow.process(outside);
  flow.reset();
  EXPECT_EQ(flow.rejected(), 0U);
  EXPECT_TRUE(same(flows_of(flow, events), expected));
}

TEST(PlaneFlow, TheStreamMayBeCutAnywhere) {
  const Events events = asap::test::golden_corner_stream(20'000);
  PlaneFlow flow({.width = 346, .height = 260});
  const Flows expected = flows_of(flow, events);
  flow.reset();
  Flows again(events.size());
  for (std::size_t i = 0; i < events.size();) {
    const std::size_t n = std::min<std::size_t>(i % 97 + 1, events.size() - i);
    flow.process(asap::EventSpan(events).subspan(i, n), std::span(again).subspan(i, n));
    flow.process({});
    i += n;
  }
  EXPECT_TRUE(same(again, expected));
}

TEST(PlaneFlow, AStampThatGoesBackCountsAsTheLatest) {
  Events jagged = asap::test::golden_corner_stream(20'000);
  Events lifted = jagged;
  for (std::size_t i = 1; i < jagged.size(); i += 3) {
    jagged[i].t -= 11 + static_cast<std::int64_t>(i);
    lifted[i].t = lifted[i - 1].t;
  }
  PlaneFlow flow({.width = 346, .height = 260});
  const Flows expected = flows_of(flow, lifted);
  flow.reset();
  EXPECT_TRUE(same(flows_of(flow, jagged), expected));
}

TEST(PlaneFlow, DropsAndCountsEventsOutsideTheFrame) {
  PlaneFlow flow({.width = 40, .height = 30});
  const Events outside{{.x = 40, .y = 0, .p = 0, .t = 1LL << 60},
                       {.x = 0, .y = 30, .p = 0, .t = 1LL << 60},
                       {.x = 65535, .y = 65535, .p = 0, .t = 0}};
  for (const Flow& f : flows_of(flow, outside)) EXPECT_TRUE(std::isnan(f.vx));
  EXPECT_EQ(flow.rejected(), 3U);
  PlaneFlow other({.width = 40, .height = 30});
  EXPECT_TRUE(same(flows_of(flow, edge(400, 300)), flows_of(other, edge(400, 300))));
}

TEST(PlaneFlow, KeepIsCheckedAndWithoutEffect) {
  const Events events = asap::test::golden_corner_stream(20'000);
  PlaneFlow told({.width = 346, .height = 260});
  PlaneFlow other({.width = 346, .height = 260});
  told.set_keep(0.1);
  EXPECT_TRUE(same(flows_of(told, events), flows_of(other, events)));
  EXPECT_NO_THROW(told.set_keep(0));
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(told.set_keep(bad), std::invalid_argument);
  }
}

TEST(PlaneFlow, FlowsOfAnotherSizeAreRefused) {
  PlaneFlow flow({.width = 40, .height = 30});
  const Events events = edge(400, 300);
  Flows flows(2);
  EXPECT_THROW(flow.process(events, flows), std::invalid_argument);
}

TEST(PlaneFlow, NamesBadParameters) {
  using asap::test::error_of;
  EXPECT_EQ(error_of([] { PlaneFlow({.width = 0, .height = 9}); }),
            "width = 0: must be 1 to 16384 px");
  EXPECT_EQ(error_of([] { PlaneFlow({.width = 9, .height = 9, .window = microseconds(0)}); }),
            "window_us = 0: must be 1 to 10000000 us");
  EXPECT_EQ(
      error_of([] { PlaneFlow({.width = 9, .height = 9, .window = microseconds(10'000'001)}); }),
      "window_us = 10000001: must be 1 to 10000000 us");
  EXPECT_EQ(error_of([] { PlaneFlow({.width = 9, .height = 9, .min_points = 2}); }),
            "min_points = 2: must be 3 to 25 px");
  EXPECT_EQ(error_of([] { PlaneFlow({.width = 9, .height = 9, .min_points = 26}); }),
            "min_points = 26: must be 3 to 25 px");
}

TEST(PlaneFlow, ACopyGoesItsOwnWay) {
  const auto events = asap::test::golden_corner_stream(20'000);
  const Events first(events.begin(), events.begin() + 10'000);
  const Events second(events.begin() + 10'000, events.end());
  PlaneFlow flow({.width = 346, .height = 260});
  flows_of(flow, first);
  PlaneFlow copy = flow;
  PlaneFlow other({.width = 1, .height = 1});
  other = copy;
  PlaneFlow moved = std::move(copy);
  copy = other;  // what was moved from takes a new value
  const auto expected = flows_of(flow, second);
  for (PlaneFlow* each : {&moved, &other, &copy}) {
    EXPECT_TRUE(same(flows_of(*each, second), expected));
    EXPECT_EQ(each->config().width, 346);
  }
}

TEST(PlaneFlow, AllocatesOnlyInTheConstructor) {
  const Events events = asap::test::golden_corner_stream(20'000);
  PlaneFlow flow({.width = 346, .height = 260});
  Flows flows(events.size());
  const std::size_t before = asap::test::allocations();
  flow.process(events, flows);
  flow.process(events);
  flow.set_keep(0.5);
  flow.reset();
  EXPECT_EQ(asap::test::allocations(), before);
}

}  // namespace
}  // namespace plane_flow_test
