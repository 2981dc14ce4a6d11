// What every benchmark of a stream reports: events per second, and the time of one event.
#pragma once

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>

namespace asap::bench {

inline void report_events(benchmark::State& state, std::size_t events_per_iteration) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(events_per_iteration));
  using Counter = benchmark::Counter;
  state.counters["s_per_event"] = Counter(static_cast<double>(events_per_iteration),
                                          Counter::kIsIterationInvariantRate | Counter::kInvert);
}

}  // namespace asap::bench
