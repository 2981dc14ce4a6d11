// Bars per event: EFast 60 ns, ArcStar 90 ns, EHarris 150 ns, on every stream. The rivals are the
// detectors as they are defined: times in 64 bits, a ring test of every arc, a queue per pixel.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/naive_corners.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "per_event.hpp"
#include "shapes.hpp"

namespace {

using asap::bench::Events;
using asap::bench::fast;
using asap::bench::golden;
using asap::bench::kEvents;
using asap::bench::noisy;
using asap::bench::Stream;

const Events& slow() {
  static const auto events = asap::test::turning_shapes({.speed = 120}, kEvents);
  return events;
}

template <class Detector>
void BM_Corners(benchmark::State& state, Stream stream) {
  const Events& events = stream();
  Detector detector{{.width = 346, .height = 260}};
  std::vector<std::uint8_t> corners(events.size());
  for (auto _ : state) {
    detector.reset();
    detector.process(events, corners);
    benchmark::ClobberMemory();
  }
  asap::bench::report_events(state, events.size());
}

template <class Naive>
void BM_RivalAsDefined(benchmark::State& state, Stream stream) {
  const Events& events = stream();
  for (auto _ : state) {
    Naive naive(346, 260);
    std::size_t corners = 0;
    for (const asap::Event& event : events) corners += naive.update(event);
    benchmark::DoNotOptimize(corners);
  }
  asap::bench::report_events(state, events.size());
}

template <class Detector, class Naive>
void add(const std::string& detector) {
  const std::vector<std::pair<std::string, Stream>> streams{
      {"golden", golden}, {"slow", slow}, {"fast", fast}, {"noisy", noisy}};
  for (const auto& [name, stream] : streams) {
    benchmark::RegisterBenchmark((detector + "/" + name).c_str(), BM_Corners<Detector>, stream);
    benchmark::RegisterBenchmark((detector + "RivalAsDefined/" + name).c_str(),
                                 BM_RivalAsDefined<Naive>, stream)
        ->Iterations(1);
  }
}

const bool added = [] {
  add<asap::EFast, asap::test::NaiveEFast>("EFast");
  add<asap::ArcStar, asap::test::NaiveArcStar>("ArcStar");
  add<asap::EHarris, asap::test::NaiveEHarris>("EHarris");
  add<asap::FAHarris, asap::test::NaiveFAHarris>("FAHarris");
  return true;
}();

}  // namespace
