// Bars: ClusterTracker at most 30 ns per event and 50 times as fast as the published rule, where
// every cluster is looked at for every event; PublishedClusterTracker at most 110 ns per event.
#include "asap/algorithms/cluster_tracker.hpp"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <vector>

#include "algorithms/cluster_streams.hpp"
#include "algorithms/naive_clusterer.hpp"
#include "asap/algorithms/noise_filters.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"

namespace {

using asap::test::make_scene;

const std::vector<asap::Event>& golden() {
  static const auto events = asap::test::golden_stream(60'000);
  return events;
}

// Twenty discs of up to 600 px/s, about 0.86 million events per second.
const std::vector<asap::Event>& quiet_scene() {
  static const auto events = make_scene({}, 60'000);
  return events;
}

// The same with 5 Hz of noise per pixel, a third of all events.
const std::vector<asap::Event>& noisy_scene() {
  static const auto events = make_scene({.noise_hz = 5}, 60'000);
  return events;
}

// A hundred discs of up to 400 px/s at 1280 x 720.
const std::vector<asap::Event>& large_scene() {
  static const auto events = make_scene(
      {.width = 1280, .height = 720, .objects = 100, .speed = 400, .noise_hz = 0.5}, 600'000);
  return events;
}

using Stream = const std::vector<asap::Event>& (*)();

// Time per event.
void set_cost(benchmark::State& state, std::size_t events) {
  state.counters["per_event"] = benchmark::Counter(
      static_cast<double>(events),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

template <class Tracker>
void run(benchmark::State& state, Stream stream, const typename Tracker::Config& config) {
  const auto& events = stream();
  Tracker tracker(config);
  for (auto _ : state) {
    tracker.reset();
    tracker.process(events);
    benchmark::ClobberMemory();
  }
  set_cost(state, events.size());
}

void BM_ClusterTracker(benchmark::State& state, Stream stream, int width, int height) {
  run<asap::ClusterTracker>(state, stream, {.width = width, .height = height});
}

void BM_Published(benchmark::State& state, Stream stream,
                  asap::PublishedClusterTrackerConfig config) {
  run<asap::PublishedClusterTracker>(state, stream, config);
}

void BM_RivalFilterThenPublished(benchmark::State& state, Stream stream,
                                 asap::PublishedClusterTrackerConfig config) {
  const auto& events = stream();
  asap::BackgroundActivityFilter filter({.width = config.width, .height = config.height});
  asap::PublishedClusterTracker tracker(config);
  std::vector<asap::Event> passed(events.size());
  for (auto _ : state) {
    filter.reset();
    tracker.reset();
    tracker.process({passed.data(), filter.process(events, passed)});
    benchmark::ClobberMemory();
  }
  set_cost(state, events.size());
}

void BM_RivalAsPublished(benchmark::State& state, Stream stream,
                         asap::PublishedClusterTrackerConfig config) {
  const auto& events = stream();
  for (auto _ : state) {
    asap::test::NaiveClusterer clusterer(config, asap::UniformProbe(config.seed));
    for (const asap::Event& event : events) clusterer.update(event);
    benchmark::ClobberMemory();
  }
  set_cost(state, events.size());
}

constexpr asap::PublishedClusterTrackerConfig kLaunch{.width = 346, .height = 260};
constexpr asap::PublishedClusterTrackerConfig kNoProbes{.width = 346, .height = 260, .probes = 0};
constexpr asap::PublishedClusterTrackerConfig kLarge{
    .width = 346, .height = 260, .window = 3200, .min_size = 60};

BENCHMARK_CAPTURE(BM_ClusterTracker, golden, golden, 346, 260);
BENCHMARK_CAPTURE(BM_Published, golden, golden, kLaunch);
BENCHMARK_CAPTURE(BM_RivalAsPublished, golden, golden, kLaunch);
BENCHMARK_CAPTURE(BM_ClusterTracker, quiet, quiet_scene, 346, 260);
BENCHMARK_CAPTURE(BM_Published, quiet, quiet_scene, kLaunch);
BENCHMARK_CAPTURE(BM_RivalFilterThenPublished, quiet, quiet_scene, kLaunch);
BENCHMARK_CAPTURE(BM_RivalAsPublished, quiet, quiet_scene, kLaunch);
BENCHMARK_CAPTURE(BM_ClusterTracker, noisy, noisy_scene, 346, 260);
BENCHMARK_CAPTURE(BM_Published, noisy, noisy_scene, kLaunch);
BENCHMARK_CAPTURE(BM_RivalFilterThenPublished, noisy, noisy_scene, kLaunch);
BENCHMARK_CAPTURE(BM_RivalAsPublished, noisy, noisy_scene, kLaunch);
BENCHMARK_CAPTURE(BM_Published, noisy_without_probes, noisy_scene, kNoProbes);
BENCHMARK_CAPTURE(BM_Published, noisy_large_window, noisy_scene, kLarge);
BENCHMARK_CAPTURE(BM_ClusterTracker, hundred_objects, large_scene, 1280, 720);

}  // namespace
