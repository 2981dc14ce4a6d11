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

// Width, height, window, radius, probes, weight, min_size.
constexpr Case kCases[] = {
    {"Launch", {346, 260, 800, 20, 1, 0.9, 15}},
    {"LaunchWithoutProbes", {346, 260, 800, 20, 0, 0.9, 15}},
    {"ConstructorDefaults", {346, 260, 800, 25, 0, 0.5, 5}},
    {"SmallWindow", {240, 180, 50, 15, 2, 0.9, 4}},
    {"WindowOfOne", {100, 80, 1, 20, 1, 0.9, 1}},
    {"WindowOfTwo", {40, 30, 2, 20, 1, 0.9, 0}},
    {"FractionalRadius", {200, 150, 200, 7.5, 1, 0.05, 6}},
    {"RadiusZero", {30, 20, 300, 0, 3, 0.3, 2}},
    {"RadiusBeyondTheFrame", {60, 40, 100, 1e9, 1, 0.9, 15}},
    {"ManyProbes", {200, 150, 300, 9, 8, 0.9, 10}},
    {"EveryLiveEventProbed", {200, 150, 300, 6, 1'000'000, 0.9, 10}},
    {"MoreProbesThanSomeHaveEvents", {200, 150, 120, 6, 5, 0.9, 3}},
    {"CentreStaysAtTheFirstEvent", {200, 150, 200, 10, 1, 0, 5}},
    {"CentreIsTheLastEvent", {200, 150, 200, 10, 1, 1, 5}},
    {"OnePixelFrame", {1, 1, 10, 20, 1, 0.9, 3}},
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

// From the authors' own class: kappa = 0, 20 000 events of stream S1. Sums over all events, of the
// updated cluster's size and centre and of the clusters that live.
struct Golden {
  PublishedClusterTrackerConfig config;
  std::uint64_t size;
  std::size_t live;
  double x, y;
};

constexpr Golden kGolden[] = {
    {{346, 260, 800, 20, 0, 0.9, 15}, 1254988, 1250342, 3403963.764, 2691511.150},
    {{346, 260, 800, 25, 0, 0.5, 5}, 1296043, 1009216, 3403645.452, 2691477.057},
    {{346, 260, 200, 15, 0, 0.8, 15}, 313605, 633657, 3403990.884, 2691464.073},
    {{346, 260, 2000, 12, 0, 0.9, 15}, 2364209, 3041147, 3403961.223, 2691485.351},
};

TEST(WindowClusterer, ReproducesTheGoldenVectors) {
  const auto events = asap::test::golden_stream();
  for (const Golden& golden : kGolden) {
    WindowClusterer<> clusterer(golden.config, UniformProbe(0));
    Golden sum{golden.config, 0, 0, 0, 0};
    for (const Event& event : events) {
      const auto& updated = clusterer[clusterer.update(event)];
      sum.size += updated.moments.count();
      sum.live += clusterer.live();
      sum.x += updated.x;
      sum.y += updated.y;
    }
    EXPECT_EQ(sum.size, golden.size);
    EXPECT_EQ(sum.live, golden.live);
    EXPECT_NEAR(sum.x, golden.x, 5e-4);
    EXPECT_NEAR(sum.y, golden.y, 5e-4);
  }
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

}  // namespace
}  // namespace window_clusterer_test
