// Bar: at most 3 ns per event on every stream. The rival is the filter as it is defined: eight
// neighbours looked at one by one, times in 64 bits.
#include "asap/algorithms/noise_filters.hpp"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "per_event.hpp"

namespace {

constexpr std::size_t kEvents = 200'000;
constexpr std::int64_t kWindow_us = 5000;

using Events = std::vector<asap::Event>;
using Stream = const Events& (*)();

const Events& golden() {
  static const auto events = asap::test::golden_corner_stream(kEvents);
  return events;
}

const Events& shapes() {
  static const auto events = asap::test::turning_shapes({.speed = 700}, kEvents);
  return events;
}

const Events& noisy_shapes() {
  static const auto events = asap::test::turning_shapes({.speed = 300, .noise_hz = 8}, kEvents);
  return events;
}

void BM_BackgroundActivityFilter(benchmark::State& state, Stream stream) {
  const Events& events = stream();
  asap::BackgroundActivityFilter filter(
      {.width = 346, .height = 260, .window = std::chrono::microseconds(kWindow_us)});
  Events out(events.size());
  for (auto _ : state) {
    filter.reset();
    benchmark::DoNotOptimize(filter.process(events, out));
    benchmark::ClobberMemory();
  }
  asap::bench::report_events(state, events.size());
}

void BM_RivalAsDefined(benchmark::State& state, Stream stream) {
  const Events& events = stream();
  Events out(events.size());
  for (auto _ : state) {
    asap::test::NaiveBackgroundActivityFilter naive(346, 260, kWindow_us);
    std::size_t passed = 0;
    for (const asap::Event& event : events) {
      if (naive.update(event)) out[passed++] = event;
    }
    benchmark::DoNotOptimize(passed);
    benchmark::ClobberMemory();
  }
  asap::bench::report_events(state, events.size());
}

BENCHMARK_CAPTURE(BM_BackgroundActivityFilter, golden, golden);
BENCHMARK_CAPTURE(BM_RivalAsDefined, golden, golden);
BENCHMARK_CAPTURE(BM_BackgroundActivityFilter, shapes, shapes);
BENCHMARK_CAPTURE(BM_RivalAsDefined, shapes, shapes);
BENCHMARK_CAPTURE(BM_BackgroundActivityFilter, noisy_shapes, noisy_shapes);
BENCHMARK_CAPTURE(BM_RivalAsDefined, noisy_shapes, noisy_shapes);

}  // namespace
