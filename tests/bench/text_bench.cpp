// Bar: text decodes at 14 M events per second or more (items_per_second).
#include "asap/formats/text.hpp"

#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "core/random.hpp"

namespace {

constexpr std::size_t kLines = 100'000;

// time(line, t_us) writes the first column and returns its length.
template <class Time>
std::string lines(Time time) {
  const asap::CounterRandom random(1);
  std::string text;
  char line[96];
  for (std::size_t i = 0; i < kLines; ++i) {
    const std::uint64_t bits = random(i);
    const int length = time(line, 1'000'000.0 + static_cast<double>(i));
    const int size = length + std::snprintf(line + length, sizeof line / 2, ",%u,%u,%u\n",
                                            static_cast<unsigned>(bits % 346),
                                            static_cast<unsigned>((bits >> 20) % 260),
                                            static_cast<unsigned>((bits >> 40) & 1));
    text.append(line, static_cast<std::size_t>(size));
  }
  return text;
}

void decode(benchmark::State& state, const std::string& text, int time_exponent) {
  std::vector<asap::Event> events;
  events.reserve(kLines);
  for (auto _ : state) {
    events.clear();
    asap::TextDecoder decoder({.time_exponent = time_exponent});
    decoder.decode(std::as_bytes(std::span(text)), events);
    benchmark::DoNotOptimize(events.data());
  }
  if (events.size() != kLines) state.SkipWithError("lines were lost");
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kLines));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}

void BM_TextSeconds(benchmark::State& state) {
  decode(state, lines([](char* to, double t_us) { return std::sprintf(to, "%.6f", t_us * 1e-6); }),
         6);
}
BENCHMARK(BM_TextSeconds);

void BM_TextSecondsNineDigits(benchmark::State& state) {
  decode(state, lines([](char* to, double t_us) { return std::sprintf(to, "%.9f", t_us * 1e-6); }),
         6);
}
BENCHMARK(BM_TextSecondsNineDigits);

void BM_TextMicroseconds(benchmark::State& state) {
  decode(state, lines([](char* to, double t_us) { return std::sprintf(to, "%.0f", t_us); }), 0);
}
BENCHMARK(BM_TextMicroseconds);

}  // namespace
