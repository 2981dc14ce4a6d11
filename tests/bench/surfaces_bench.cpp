// Surfaces, plane-fit flow, images and the hot-pixel mask. The rivals are the algorithms as they
// are defined: borders tested pixel by pixel, means removed before the sums; for the images and the
// mask a loop that only adds up per pixel.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/naive_surfaces.hpp"
#include "asap/algorithms/event_image.hpp"
#include "asap/algorithms/event_surface.hpp"
#include "asap/algorithms/noise_filters.hpp"
#include "asap/algorithms/plane_flow.hpp"
#include "per_event.hpp"
#include "shapes.hpp"

namespace {

using asap::bench::Events;
using asap::bench::fast;
using asap::bench::golden;
using asap::bench::noisy;
using asap::bench::Stream;

const std::vector<std::pair<std::string, Stream>> kStreams{
    {"golden", golden}, {"fast", fast}, {"noisy", noisy}};

template <class Algorithm>
void run(benchmark::State& state, Algorithm algorithm, Stream stream) {
  const Events& events = stream();
  for (auto _ : state) {
    algorithm.reset();
    algorithm.process(events);
    benchmark::ClobberMemory();
  }
  asap::bench::report_events(state, events.size());
}

template <class Naive>
void run_naive(benchmark::State& state, const Naive& fresh, Stream stream) {
  const Events& events = stream();
  for (auto _ : state) {
    Naive naive = fresh;
    for (const asap::Event& event : events) naive.update(event);
    benchmark::DoNotOptimize(naive);
  }
  asap::bench::report_events(state, events.size());
}

void run_mask(benchmark::State& state, Stream stream) {
  const Events& events = stream();
  asap::HotPixelMask mask({.width = 346, .height = 260});
  Events out(events.size());
  for (auto _ : state) {
    mask.reset();
    benchmark::DoNotOptimize(mask.process(events, out));
    benchmark::ClobberMemory();
  }
  asap::bench::report_events(state, events.size());
}

// Adds up per pixel and copies the event: what nobody can leave out.
class Count {
 public:
  void update(const asap::Event& event) {
    ++counts_[event.y * std::size_t{346} + event.x];
    copy_ = event;
    benchmark::DoNotOptimize(copy_);
  }

 private:
  std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(346 * 260);
  asap::Event copy_{};
};

template <class Algorithm>
void add(const std::string& name, const Algorithm& algorithm) {
  for (const auto& [stream, events] : kStreams) {
    benchmark::RegisterBenchmark((name + "/" + stream).c_str(), run<Algorithm>, algorithm, events);
  }
}

template <class Naive>
void add_rival(const std::string& name, const Naive& naive) {
  for (const auto& [stream, events] : kStreams) {
    benchmark::RegisterBenchmark((name + "RivalAsDefined/" + stream).c_str(), run_naive<Naive>,
                                 naive, events);
  }
}

const bool added = [] {
  using asap::EventImage;
  using asap::PlaneFlow;
  add("ThresholdOrdinalSurface", asap::ThresholdOrdinalSurface({.width = 346, .height = 260}));
  add_rival("ThresholdOrdinalSurface", asap::test::NaiveThresholdOrdinalSurface(346, 260, 7));
  add("SpeedInvariantTimeSurface", asap::SpeedInvariantTimeSurface({.width = 346, .height = 260}));
  add_rival("SpeedInvariantTimeSurface", asap::test::NaiveSpeedInvariantTimeSurface(346, 260, 6));
  using Refit = std::optional<bool>;
  for (const auto& [name, refit] : {std::pair{"PlaneFlow", Refit{}},
                                    {"PlaneFlowPublished", Refit{true}},
                                    {"PlaneFlowWithoutRefit", Refit{false}}}) {
    add(name, PlaneFlow({.width = 346, .height = 260, .refit = refit}));
    add_rival(name, asap::test::NaivePlaneFlow(346, 260, 40'000, 7, refit));
  }
  for (const std::int64_t count : {10'000, 100'000}) {
    add("EventImage" + std::to_string(count),
        EventImage({.width = 346, .height = 260, .count = count}));
  }
  for (const auto& [stream, events] : kStreams) {
    benchmark::RegisterBenchmark(("HotPixelMask/" + stream).c_str(), run_mask, events);
  }
  add_rival("EventImageAndHotPixelMask", Count());
  return true;
}();

}  // namespace
