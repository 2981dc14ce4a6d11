// Synthetic streams: events made per second. The demo feeds the simulator with them, so they have
// to be faster than it.
#include <benchmark/benchmark.h>

#include "asap/synthetic/streams.hpp"

namespace {

template <class Stream>
void make_events(benchmark::State& state) {
  std::int64_t events = 0;
  for (auto _ : state) {
    Stream stream;
    for (asap::EventSpan block = stream.next(); !block.empty(); block = stream.next()) {
      benchmark::DoNotOptimize(block.data());
      events += static_cast<std::int64_t>(block.size());
    }
  }
  state.SetItemsProcessed(events);
}
BENCHMARK(make_events<asap::ShakenPattern>)->Name("ShakenPattern")->Unit(benchmark::kMillisecond);
BENCHMARK(make_events<asap::FlightOverChairs>)
    ->Name("FlightOverChairs")
    ->Unit(benchmark::kMillisecond);

}  // namespace
