// Bar: at least 20 million events per second in virtual time, streamed in chunks, for every scheme
// that makes packages. Single events make one package each; their figure is given beside.
#include "asap/runner/simulator.hpp"

#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "per_event.hpp"
#include "support/streams.hpp"

namespace {

constexpr std::size_t kEvents = 2'000'000;
constexpr std::size_t kChunk = std::size_t{1} << 15;

template <class Scheme>
void simulate(benchmark::State& state) {
  const std::vector<asap::Event> events = asap::test::evenly_spaced(kEvents, 1);
  Scheme scheme;
  std::uint64_t delivered = 0;
  std::size_t packages = 0;
  for (auto _ : state) {
    asap::Simulator simulator(scheme, asap::LinearCost{{.alpha_us = 100, .beta_ns = 300}});
    for (std::size_t at = 0; at < kEvents; at += kChunk) {
      simulator.feed(asap::EventSpan(events).subspan(at, std::min(kChunk, kEvents - at)));
    }
    simulator.finish();
    delivered = simulator.ledger().delivered;
    packages = simulator.log().size();
  }
  asap::bench::report_events(state, kEvents);
  state.counters["delivered"] = static_cast<double>(delivered);
  state.counters["packages"] = static_cast<double>(packages);
}
BENCHMARK_TEMPLATE(simulate, asap::FixedSize)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(simulate, asap::FixedTime)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(simulate, asap::Greedy)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(simulate, asap::Asap2020)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(simulate, asap::SingleEvent)->Unit(benchmark::kMillisecond);

}  // namespace
