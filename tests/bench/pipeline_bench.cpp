// Bar: a live run, from push to the booked package, costs no more per event than the same way with
// the stamps as times; both on one thread, the algorithm left out. Packages of 1000 or of all that
// waits.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdint>
#include <vector>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/fixed.hpp"
#include "buffer/age_slots.hpp"
#include "buffer/event_buffer.hpp"
#include "packager/event_times.hpp"
#include "packager/packager.hpp"
#include "per_event.hpp"
#include "runner/clock.hpp"
#include "runner/consumer_loop.hpp"
#include "runner/doorbell.hpp"
#include "support/streams.hpp"

namespace {

constexpr std::size_t kPushes = 100;  // of one round
const asap::RunConfig kWhole{.latency = std::chrono::seconds(1),
                             .capacity = std::size_t{1} << 20,
                             .execution = asap::Execution::whole};

// By arrival: the pipeline.
void BM_Pipeline(benchmark::State& state) {
  const auto size = static_cast<std::size_t>(state.range(0));
  const std::vector<asap::Event> events = asap::test::evenly_spaced(size, 0, 1000);
  asap::FixedSize scheme({.size = size});
  asap::Pipeline pipeline(scheme, kWhole);
  asap::Package package;
  std::uint64_t sum = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < kPushes; ++i) {
      pipeline.push(events);
      pipeline.next(package, std::chrono::nanoseconds(0));
      sum += package.events.size();
    }
  }
  benchmark::DoNotOptimize(sum);
  asap::bench::report_events(state, kPushes * size);
}
BENCHMARK(BM_Pipeline)->ArgName("size")->Arg(1)->Arg(100)->Arg(1000)->Arg(10'000);

// By stamp: the same parts as a replay puts them together.
void BM_ByStamp(benchmark::State& state) {
  const auto size = static_cast<std::size_t>(state.range(0));
  const std::vector<asap::Event> events = asap::test::evenly_spaced(size, 0, 1000);
  asap::FixedSize scheme({.size = size});
  asap::Validator validator;
  asap::Telemetry telemetry(1'000'000'000, 4 * asap::RunLog::kBlockRows);
  asap::EventBuffer buffer(std::size_t{1} << 20);
  asap::AgeSlots ages(15'625'000);
  asap::Packager packager(buffer, ages, scheme, telemetry);
  const asap::TimeAxis axis(0, 1.0);
  packager.begin(axis, 0);
  asap::RunClock clock;
  clock.start(1'000'000);
  asap::Doorbell doorbell;
  asap::ConsumerLoop loop(buffer, packager, telemetry, doorbell, clock);
  asap::Package package;
  std::uint64_t sum = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < kPushes; ++i) {
      validator.check(events, [&](asap::EventSpan good) {
        const std::uint64_t first = buffer.tail();
        const std::size_t taken = buffer.push(good);
        ages.observe(good.first(taken), first,
                     [&](std::int64_t stamp) { return axis.to_ns(stamp); });
        doorbell.announce(buffer.tail());
      });
      loop.next(package, std::chrono::nanoseconds(0));
      sum += package.events.size();
      loop.complete(package);
    }
  }
  benchmark::DoNotOptimize(sum);
  asap::bench::report_events(state, kPushes * size);
}
BENCHMARK(BM_ByStamp)->ArgName("size")->Arg(1)->Arg(100)->Arg(1000)->Arg(10'000);

}  // namespace
