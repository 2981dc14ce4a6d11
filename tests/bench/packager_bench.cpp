// Bar: from the ring to the booked package, the algorithm left out: at most 3 ns per event for
// packages of 100 and more, 8 ns for single events. complete() is included: latency histogram, log,
// feed back. The rival is what the public implementation of 2022 does: a locked std::queue, event
// by event.
#include "packager/packager.hpp"

#include <benchmark/benchmark.h>

#include <cstdint>
#include <mutex>
#include <optional>
#include <queue>
#include <vector>

#include "asap/schemes/fixed.hpp"
#include "packager/event_times.hpp"
#include "per_event.hpp"
#include "support/streams.hpp"

namespace {

using asap::Event;

constexpr std::size_t kPackages = 4000;  // of one round
constexpr std::int64_t kBound_ns = 1'000'000'000;

std::vector<Event> events_of_one_round(const benchmark::State& state) {
  return asap::test::evenly_spaced(kPackages * static_cast<std::size_t>(state.range(0)), 1);
}

// A round fits into one block of the log: the figure is the cost of the code. A log that grows
// costs the kernel's fresh pages on top, about 20 ns per row.
void BM_Packager(benchmark::State& state) {
  const std::vector<Event> events = events_of_one_round(state);
  asap::FixedSize scheme({.size = static_cast<std::size_t>(state.range(0))});
  asap::EventBuffer buffer(events.size());
  const asap::AgeSlots ages(156'250);
  std::optional<asap::Telemetry> telemetry;
  std::uint64_t sum = 0;
  for (auto _ : state) {
    state.PauseTiming();
    buffer.push(events);
    telemetry.emplace(kBound_ns);
    asap::Packager packager(buffer, ages, scheme, *telemetry, {.seed = 1});
    packager.begin(asap::TimeAxis(0, 1.0), 0);
    state.ResumeTiming();
    std::int64_t now_ns = events.back().t * 1000;
    for (;;) {
      telemetry->log.make_room();
      const asap::Packager::Next next = packager.next(now_ns);
      if (next.step != asap::Packager::Step::package) break;
      sum += next.package.events.size();
      packager.complete(next.package, now_ns += 100);
    }
  }
  benchmark::DoNotOptimize(sum);
  asap::bench::report_events(state, events.size());
}
BENCHMARK(BM_Packager)->ArgName("size")->Arg(1)->Arg(10)->Arg(100)->Arg(1000);

void BM_RivalLockedQueue(benchmark::State& state) {
  const std::vector<Event> events = events_of_one_round(state);
  const auto size = static_cast<std::size_t>(state.range(0));
  std::vector<Event> package;
  for (auto _ : state) {
    state.PauseTiming();
    std::queue<Event> queue;
    std::mutex mutex;
    for (const Event& event : events) queue.push(event);
    state.ResumeTiming();
    while (!queue.empty()) {
      package.clear();
      while (package.size() < size) {
        const std::lock_guard lock(mutex);
        if (queue.empty()) break;
        package.push_back(queue.front());
        queue.pop();
      }
      benchmark::DoNotOptimize(package.data());
    }
  }
  asap::bench::report_events(state, events.size());
}
BENCHMARK(BM_RivalLockedQueue)->ArgName("size")->Arg(1)->Arg(10)->Arg(100)->Arg(1000);

}  // namespace
