#include "algorithms/window_clusterer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "algorithms/brute_force_moments.hpp"
#include "algorithms/cluster_streams.hpp"
#include "algorithms/naive_clusterer.hpp"

namespace window_clusterer_test {
namespace {

using asap::Cluster;
using asap::Event;
using asap::ProbeDraw;
using asap::PublishedClusterTrackerConfig;
using asap::UniformProbe;
using asap::WindowClusterer;
using asap::test::NaiveClusterer;

// The samplers of the oracle test: the same live event on both sides, found by its rank in time.
std::uint64_t rank(const ProbeDraw& draw, std::uint64_t count) {
  return asap::detail::mix(asap::detail::mix(asap::detail::mix(draw.event + 1) + draw.cluster) +
                           draw.probe) %
         count;
}

struct ByRank {  // members come in time order
  template <class Member>
  auto operator()(const ProbeDraw& draw, std::uint64_t count, Member&& member) {
    return member(rank(draw, count));
  }
};

struct ByRankOfAge {  // members are positions in a ring of `window` entries
  std::uint64_t window;

  template <class Member>
  auto operator()(const ProbeDraw& draw, std::uint64_t count, Member&& member) {
    std::vector<decltype(member(0))> positions;
    for (std::uint64_t i = 0; i < count; ++i) positions.push_back(member(i));
    const std::uint64_t free_place = draw.event % window;
    std::sort(positions.begin(), positions.end(), [&](std::uint64_t a, std::uint64_t b) {
      return (a + window - free_place) % window < (b + window - free_place) % window;
    });
    return positions[rank(draw, count)];
  }

  void clear() {}
};

std::vector<Event> members(const NaiveClusterer<ByRank>::State& state) {
  std::vector<Event> events;
  for (const auto& member : state.members) events.push_back(member.event);
  return events;
}

// Events in clumps that drift and meet, on the frame's borders too, with noise and equal stamps.
std::vector<Event> clumps(const PublishedClusterTrackerConfig& config, std::size_t count,
                          std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto below = [&random](int n) {
    return static_cast<int>(random() % static_cast<std::uint64_t>(n));
  };
  const int clumps = 1 + below(12);
  const int spread = 1 + below(static_cast<int>(config.radius) + 4);
  std::vector<Event> events;
  std::int64_t t = 1000;
  for (std::size_t i = 0; i < count; ++i) {
    const int clump = below(clumps);
    const int drift = static_cast<int>(i) / (20 + clump);
    int x = (37 * clump + drift) % config.width + below(spread) - spread / 2;
    int y = (53 * clump + drift / 2) % config.height + below(spread) - spread / 2;
    if (below(6) == 0) {
      x = below(config.width);
      y = below(config.height);
    }
    t += std::max(0, below(20) - 10);
    events.push_back({.x = static_cast<std::uint16_t>(std::clamp(x, 0, config.width - 1)),
                      .y = static_cast<std::uint16_t>(std::clamp(y, 0, config.height - 1)),
                      .p = 0,
                      .t = t});
  }
  return events;
}

struct OracleRun {
  std::size_t max_big = 0;  // largest number of clusters above min_size
  std::size_t fewer = 0;    // events after which fewer clusters live than before: merges
};

// Compares everything that can be seen, after every event.
OracleRun expect_equals_oracle(const PublishedClusterTrackerConfig& config,
                               const std::vector<Event>& events) {
  WindowClusterer<ByRankOfAge> clusterer(config, {static_cast<std::uint64_t>(config.window)});
  NaiveClusterer<ByRank> oracle(config, {});
  OracleRun run;
  std::size_t live_before = 0;
  std::vector<Cluster> reported;
  for (std::size_t i = 0; i < events.size(); ++i) {
    SCOPED_TRACE("event " + std::to_string(i));
    const auto& state = clusterer[clusterer.update(events[i])];
    const auto& truth = oracle.update(events[i]);
    EXPECT_NEAR(state.x, truth.x, 1e-9);
    EXPECT_NEAR(state.y, truth.y, 1e-9);
    EXPECT_EQ(state.moments.count(), truth.members.size());
    EXPECT_EQ(state.id, truth.id);
    EXPECT_EQ(clusterer.live(), oracle.clusters().size());
    const auto live_events = members(truth);
    asap::test::expect_moments(state.moments.centroid(), state.moments.covariance(),
                               state.moments.velocity(events[i].t),
                               asap::test::BruteForce(live_events));

    clusterer.read(reported);
    auto expected = oracle.clusters();
    std::erase_if(expected, [&](const auto& c) {
      return c.members.size() < static_cast<std::size_t>(config.min_size);
    });
    std::sort(expected.begin(), expected.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
    EXPECT_EQ(reported.size(), expected.size());
    for (std::size_t k = 0; k < std::min(reported.size(), expected.size()); ++k) {
      EXPECT_EQ(reported[k].id, expected[k].id);
      EXPECT_EQ(reported[k].size, static_cast<std::int64_t>(expected[k].members.size()));
      EXPECT_EQ(reported[k].t_last, expected[k].members.back().event.t);
      const Cluster& c = reported[k];
      EXPECT_TRUE(std::isinf(c.pxx) && std::isinf(c.pyy) && c.pxy == 0);
      asap::test::expect_moments({c.x, c.y}, {c.cxx, c.cxy, c.cyy}, {c.vx * 1e-6, c.vy * 1e-6},
                                 asap::test::BruteForce(members(expected[k])));
    }
    if (::testing::Test::HasFailure()) return run;

    const auto big =
        std::count_if(oracle.clusters().begin(), oracle.clusters().end(), [&](const auto& c) {
          return c.members.size() > static_cast<std::size_t>(config.min_size);
        });
    run.max_big = std::max(run.max_big, static_cast<std::size_t>(big));
    if (live_before > oracle.clusters().size()) ++run.fewer;
    live_before = oracle.clusters().size();
  }
  return run;
}

struct Case {
  const char* name;
  PublishedClusterTrackerConfig config;

  friend std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }
};

class WindowClustererOracle : public ::testing::TestWithParam<Case> {};

TEST_P(WindowClustererOracle, EqualsTheNaiveRuleEventByEvent) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_equals_oracle(GetParam().config, clumps(GetParam().config, 1200, seed));
    if (HasFailure()) return;
  }
}

constexpr Case kCases[] = {
    {"Launch", {.width = 346, .height = 260}},
    {"LaunchWithoutProbes", {.width = 346, .height = 260, .probes = 0}},
    {"ConstructorDefaults",
     {.width = 346, .height = 260, .radius = 25, .probes = 0, .weight = 0.5, .min_size = 5}},
    {"SmallWindow",
     {.width = 240, .height = 180, .window = 50, .radius = 15, .probes = 2, .min_size = 4}},
    {"WindowOfOne", {.width = 100, .height = 80, .window = 1, .probes = 1, .min_size = 1}},
    {"WindowOfTwo", {.width = 40, .height = 30, .window = 2, .probes = 1, .min_size = 0}},
    {"FractionalRadius",
     {.width = 200,
      .height = 150,
      .window = 200,
      .radius = 7.5,
      .probes = 1,
      .weight = 0.05,
      .min_size = 6}},
    {"RadiusZero",
     {.width = 30,
      .height = 20,
      .window = 300,
      .radius = 0,
      .probes = 3,
      .weight = 0.3,
      .min_size = 2}},
    {"RadiusBeyondTheFrame",
     {.width = 60, .height = 40, .window = 100, .radius = 1e9, .probes = 1}},
    {"ManyProbes",
     {.width = 200, .height = 150, .window = 300, .radius = 9, .probes = 8, .min_size = 10}},
    {"EveryLiveEventProbed",
     {.width = 200,
      .height = 150,
      .window = 300,
      .radius = 6,
      .probes = 1'000'000,
      .min_size = 10}},
    {"MoreProbesThanSomeHaveEvents",
     {.width = 200, .height = 150, .window = 120, .radius = 6, .probes = 5, .min_size = 3}},
    {"CentreStaysAtTheFirstEvent",
     {.width = 200,
      .height = 150,
      .window = 200,
      .radius = 10,
      .probes = 1,
      .weight = 0,
      .min_size = 5}},
    {"CentreIsTheLastEvent",
     {.width = 200,
      .height = 150,
      .window = 200,
      .radius = 10,
      .probes = 1,
      .weight = 1,
      .min_size = 5}},
    {"OnePixelFrame", {.width = 1, .height = 1, .window = 10, .probes = 1, .min_size = 3}},
};
INSTANTIATE_TEST_SUITE_P(Settings, WindowClustererOracle, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return test.param.name; });

TEST(WindowClusterer, EqualsTheOracleOnTheGoldenStream) {
  const auto run =
      expect_equals_oracle({.width = 346, .height = 260}, asap::test::golden_stream(3000));
  EXPECT_GT(run.fewer, 100U);
}

// More big clusters than the probe index has keys: the others are probed on every event.
TEST(WindowClusterer, IsExactBeyondTheKeysOfTheProbeIndex) {
  for (const int min_size : {0, 1, 2}) {
    const PublishedClusterTrackerConfig config{.width = 300,
                                               .height = 300,
                                               .window = 1500,
                                               .radius = 3,
                                               .probes = 1,
                                               .min_size = min_size};
    std::mt19937_64 random(3);
    std::vector<Event> events;
    for (int i = 0; i < 2500; ++i) {
      const auto jitter = [&random] { return static_cast<int>(random() % 4); };
      // Every fifth event between the lattice points: merges, and clusters that leave and come
      // back.
      const int pitch = random() % 5 == 0 ? 7 : 14;
      events.push_back(
          {.x = static_cast<std::uint16_t>(static_cast<int>(random() % 20) * pitch + jitter()),
           .y = static_cast<std::uint16_t>(static_cast<int>(random() % 20) * pitch + jitter()),
           .p = 0,
           .t = i});
    }
    const auto run = expect_equals_oracle(config, events);
    EXPECT_GT(run.max_big, 140U);
    EXPECT_GT(run.fewer, 100U);
  }
}

// From the authors' own class: kappa = 0, 20 000 events of stream S1.
struct Golden {
  PublishedClusterTrackerConfig config;
  std::size_t live[3];  // after 1000, 5000, 20 000 events
  std::size_t reported[3];
  std::uint64_t n;  // of the last event's cluster
  double x, y;
  std::uint64_t sum_n;  // of the updated cluster, over all events
  std::size_t sum_live;
  double sum_x, sum_y;
};

constexpr Golden kGolden[] = {
    {{.width = 346,
      .height = 260,
      .window = 800,
      .radius = 20,
      .probes = 0,
      .weight = 0.9,
      .min_size = 15},
     {64, 66, 60},
     {10, 10, 10},
     78,
     121.381040,
     200.227939,
     1254988,
     1250342,
     3403963.764,
     2691511.150},
    {{.width = 346,
      .height = 260,
      .window = 800,
      .radius = 25,
      .probes = 0,
      .weight = 0.5,
      .min_size = 5},
     {52, 54, 48},
     {10, 12, 10},
     81,
     118.985833,
     199.550341,
     1296043,
     1009216,
     3403645.452,
     2691477.057},
    {{.width = 346,
      .height = 260,
      .window = 200,
      .radius = 15,
      .probes = 0,
      .weight = 0.8,
      .min_size = 15},
     {32, 29, 31},
     {7, 9, 8},
     19,
     120.735677,
     200.303607,
     313605,
     633657,
     3403990.884,
     2691464.073},
    {{.width = 346,
      .height = 260,
      .window = 2000,
      .radius = 12,
      .probes = 0,
      .weight = 0.9,
      .min_size = 15},
     {109, 156, 159},
     {10, 11, 10},
     182,
     121.381040,
     200.227939,
     2364209,
     3041147,
     3403961.223,
     2691485.351},
};

TEST(WindowClusterer, ReproducesTheGoldenVectors) {
  const auto events = asap::test::golden_stream();
  for (const Golden& golden : kGolden) {
    SCOPED_TRACE("window " + std::to_string(golden.config.window) + ", radius " +
                 std::to_string(golden.config.radius));
    WindowClusterer<> clusterer(golden.config, UniformProbe(0));
    std::uint64_t sum_n = 0;
    std::size_t sum_live = 0;
    double sum_x = 0, sum_y = 0;
    std::vector<Cluster> reported;
    WindowClusterer<>::Slot last = 0;
    for (std::size_t i = 0; i < events.size(); ++i) {
      last = clusterer.update(events[i]);
      sum_n += clusterer[last].moments.count();
      sum_live += clusterer.live();
      sum_x += clusterer[last].x;
      sum_y += clusterer[last].y;
      for (std::size_t k = 0; k < 3; ++k) {
        if (i + 1 != std::size_t{k == 0 ? 1000U : k == 1 ? 5000U : 20'000U}) continue;
        clusterer.read(reported);
        EXPECT_EQ(clusterer.live(), golden.live[k]);
        EXPECT_EQ(reported.size(), golden.reported[k]);
      }
    }
    EXPECT_EQ(clusterer[last].moments.count(), golden.n);
    EXPECT_NEAR(clusterer[last].x, golden.x, 5e-7);
    EXPECT_NEAR(clusterer[last].y, golden.y, 5e-7);
    EXPECT_EQ(sum_n, golden.sum_n);
    EXPECT_EQ(sum_live, golden.sum_live);
    EXPECT_NEAR(sum_x, golden.sum_x, 5e-4);
    EXPECT_NEAR(sum_y, golden.sum_y, 5e-4);
    if (&golden == &kGolden[0]) {
      EXPECT_NEAR(clusterer[last].moments.centroid().x, 110.910256, 5e-7);
      EXPECT_NEAR(clusterer[last].moments.centroid().y, 193.884615, 5e-7);
    }
  }
}

TEST(WindowClusterer, GoldenStreamIsTheGoldenStream) {
  const auto events = asap::test::golden_stream();
  std::uint64_t x = 0, y = 0, p = 0;
  for (const Event& event : events) {
    x += event.x;
    y += event.y;
    p += static_cast<std::uint64_t>(event.p);
  }
  EXPECT_EQ(x, 3403977U);
  EXPECT_EQ(y, 2691457U);
  EXPECT_EQ(p, 10096U);
}

// With the sampler of the published rule only the distribution can be compared.
TEST(WindowClusterer, UniformProbesHaveTheDistributionOfTheNaiveRule) {
  const auto events = asap::test::golden_stream(4000);
  const auto spread = [&](auto&& run) {
    double sum = 0, squares = 0;
    constexpr int kSeeds = 24;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const double value = run(seed);
      sum += value;
      squares += value * value;
    }
    const double mean = sum / kSeeds;
    return std::pair(mean,
                     (squares / kSeeds - mean * mean) / (kSeeds - 1));  // variance of the mean
  };
  // The mean size of the cluster that takes an event: merges by chance make it larger.
  const auto [ours, our_variance] = spread([&](std::uint64_t seed) {
    const PublishedClusterTrackerConfig config{
        .width = 346, .height = 260, .radius = 20, .probes = 2};
    WindowClusterer<> clusterer(config, UniformProbe(seed));
    double size = 0;
    for (const Event& event : events)
      size += static_cast<double>(clusterer[clusterer.update(event)].moments.count());
    return size / static_cast<double>(events.size());
  });
  const auto [naive, naive_variance] = spread([&](std::uint64_t seed) {
    const PublishedClusterTrackerConfig config{
        .width = 346, .height = 260, .radius = 20, .probes = 2};
    NaiveClusterer<UniformProbe> clusterer(config, UniformProbe(seed + 1000));
    double size = 0;
    for (const Event& event : events)
      size += static_cast<double>(clusterer.update(event).members.size());
    return size / static_cast<double>(events.size());
  });
  EXPECT_GT(our_variance, 0);
  EXPECT_NEAR(ours, naive, 4 * std::sqrt(our_variance + naive_variance));
}

TEST(WindowClusterer, OfEqualStampsExactlyTheLastAreKept) {
  const PublishedClusterTrackerConfig config{
      .width = 50, .height = 50, .window = 10, .min_size = 1};
  WindowClusterer<> clusterer(config, UniformProbe(0));
  WindowClusterer<>::Slot slot = 0;
  for (int i = 0; i < 100; ++i) slot = clusterer.update({.x = 5, .y = 5, .p = 0, .t = 7});
  EXPECT_EQ(clusterer[slot].moments.count(), 10U);
  EXPECT_EQ(clusterer.live(), 1U);
}

TEST(WindowClusterer, ClearIsTheStateAfterConstruction) {
  // The second setting has more big clusters than the probe index has keys.
  for (const PublishedClusterTrackerConfig& config :
       {PublishedClusterTrackerConfig{.width = 346, .height = 260},
        PublishedClusterTrackerConfig{.width = 346, .height = 260, .radius = 2, .min_size = 0}}) {
    const ByRankOfAge sampler{static_cast<std::uint64_t>(config.window)};
    WindowClusterer<ByRankOfAge> fresh(config, sampler);
    WindowClusterer<ByRankOfAge> used(config, sampler);
    for (const Event& event : asap::test::make_scene({.noise_hz = 5}, 3001)) used.update(event);
    used.clear();
    EXPECT_EQ(used.live(), 0U);
    for (const Event& event : asap::test::golden_stream(3000)) {
      const auto& a = fresh[fresh.update(event)];
      const auto& b = used[used.update(event)];
      ASSERT_EQ(a.x, b.x);
      ASSERT_EQ(a.id, b.id);
      ASSERT_EQ(a.created, b.created);
      ASSERT_EQ(a.key, b.key);
      ASSERT_EQ(a.moments.count(), b.moments.count());
      ASSERT_EQ(fresh.live(), used.live());
    }
  }
}

}  // namespace
}  // namespace window_clusterer_test
