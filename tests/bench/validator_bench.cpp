// Bar: good input costs at most 1.5 ns per event (items_per_second >= 667 M/s).
#include "asap/filter/validator.hpp"

#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "core/random.hpp"

namespace {

constexpr int kWidth = 346;
constexpr int kHeight = 260;

std::vector<asap::Event> random_events(std::size_t count) {
  const asap::CounterRandom random(1);
  std::vector<asap::Event> events(count);
  std::int64_t t = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random(i);
    t += static_cast<std::int64_t>(bits >> 62);
    events[i] = {static_cast<std::uint16_t>(bits % kWidth),
                 static_cast<std::uint16_t>((bits >> 20) % kHeight),
                 static_cast<std::int16_t>((bits >> 40) & 1), t};
  }
  return events;
}

// A new validator each time: for an old one the same events would be a step back in time.
void check(benchmark::State& state, std::vector<asap::Event> events) {
  std::uint64_t sunk = 0;
  for (auto _ : state) {
    asap::Validator validator({.width = kWidth, .height = kHeight});
    validator.check(events, [&](asap::EventSpan run) { sunk += run.size(); });
  }
  benchmark::DoNotOptimize(sunk);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(events.size()));
}

void BM_ValidatorClean(benchmark::State& state) {
  check(state, random_events(static_cast<std::size_t>(state.range(0))));
}
BENCHMARK(BM_ValidatorClean)->Arg(100)->Arg(10'000)->Arg(1'000'000);

void BM_ValidatorOneInThousandBad(benchmark::State& state) {
  auto events = random_events(static_cast<std::size_t>(state.range(0)));
  for (std::size_t i = 500; i < events.size(); i += 1000) events[i].x = kWidth;
  check(state, events);
}
BENCHMARK(BM_ValidatorOneInThousandBad)->Arg(1'000'000);

void BM_ValidatorSignedPolarity(benchmark::State& state) {
  auto events = random_events(static_cast<std::size_t>(state.range(0)));
  for (auto& event : events) event.p = event.p > 0 ? 1 : -1;
  check(state, events);
}
BENCHMARK(BM_ValidatorSignedPolarity)->Arg(1'000'000);

}  // namespace
