// Filters, corner detectors, surfaces, plane-fit flow and images, each on four streams. The rivals
// are the rules as they are defined: times in 64 bits, neighbours looked at one by one, borders
// tested pixel by pixel, a queue per pixel; for images and mask a loop that only adds up per pixel.
// Bars per event: BackgroundActivityFilter 3 ns, EFast 60 ns, ArcStar 90 ns, EHarris 150 ns.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/naive_corners.hpp"
#include "algorithms/naive_surfaces.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/event_image.hpp"
#include "asap/algorithms/event_surface.hpp"
#include "asap/algorithms/noise_filters.hpp"
#include "asap/algorithms/plane_flow.hpp"
#include "per_event.hpp"

namespace {

using Events = std::vector<asap::Event>;

constexpr std::size_t kEvents = 200'000;
constexpr int kWidth = 346;
constexpr int kHeight = 260;

// ArcStar tests 82 % of the events of the first, a quarter of those of the others.
const std::vector<std::pair<std::string, Events>>& streams() {
  using asap::test::turning_shapes;
  static const std::vector<std::pair<std::string, Events>> all{
      {"golden", asap::test::golden_corner_stream(kEvents)},
      {"slow", turning_shapes({.speed = 120}, kEvents)},
      {"fast", turning_shapes({.speed = 700}, kEvents)},
      {"noisy", turning_shapes({.speed = 300, .noise_hz = 8}, kEvents)}};
  return all;
}

// `Out` is what it writes for each event, if that is anything.
template <class Algorithm, class Out>
void run(benchmark::State& state, const typename Algorithm::Config& config, const Events& events) {
  Algorithm algorithm(config);
  std::vector<std::conditional_t<std::is_void_v<Out>, char, Out>> out(events.size());
  for (auto _ : state) {
    algorithm.reset();
    if constexpr (std::is_void_v<Out>) {
      algorithm.process(events);
    } else {
      static_cast<void>(algorithm.process(events, out));
    }
    benchmark::ClobberMemory();
  }
  asap::bench::report_events(state, events.size());
}

template <class Naive>
void run_naive(benchmark::State& state, const Naive& fresh, const Events& events) {
  for (auto _ : state) {
    Naive naive = fresh;
    for (const asap::Event& event : events) {
      if constexpr (std::is_void_v<decltype(naive.update(event))>) {
        naive.update(event);
      } else {
        benchmark::DoNotOptimize(naive.update(event));
      }
    }
    benchmark::DoNotOptimize(naive);
  }
  asap::bench::report_events(state, events.size());
}

// Adds up per pixel and copies the event: the least that images and mask have to do.
class Count {
 public:
  void update(const asap::Event& event) {
    ++counts_[event.y * std::size_t{kWidth} + event.x];
    copy_ = event;
    benchmark::DoNotOptimize(copy_);
  }

 private:
  std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(kWidth * kHeight);
  asap::Event copy_{};
};

template <class Algorithm, class Out = void>
void add(const std::string& name, typename Algorithm::Config config) {
  config.width = kWidth;
  config.height = kHeight;
  for (const auto& [stream, events] : streams()) {
    benchmark::RegisterBenchmark((name + "/" + stream).c_str(), run<Algorithm, Out>, config,
                                 events);
  }
}

template <class Naive>
void add_rival(const std::string& name, const Naive& naive) {
  for (const auto& [stream, events] : streams()) {
    benchmark::RegisterBenchmark((name + "RivalAsDefined/" + stream).c_str(), run_naive<Naive>,
                                 naive, events);
  }
}

template <class Detector, class Naive>
void add_detector(const std::string& name) {
  add<Detector, std::uint8_t>(name, {.width = 0, .height = 0});
  add_rival(name, Naive(kWidth, kHeight));
}

const bool added = [] {
  namespace test = asap::test;
  using std::chrono::microseconds;
  add<asap::BackgroundActivityFilter, asap::Event>(
      "BackgroundActivityFilter", {.width = 0, .height = 0, .window = microseconds(5000)});
  add_rival("BackgroundActivityFilter", test::NaiveBackgroundActivityFilter(kWidth, kHeight, 5000));
  add_detector<asap::EFast, test::NaiveEFast>("EFast");
  add_detector<asap::ArcStar, test::NaiveArcStar>("ArcStar");
  add_detector<asap::EHarris, test::NaiveEHarris>("EHarris");
  add_detector<asap::FAHarris, test::NaiveFAHarris>("FAHarris");
  add<asap::ThresholdOrdinalSurface>("ThresholdOrdinalSurface", {.width = 0, .height = 0});
  add_rival("ThresholdOrdinalSurface", test::NaiveThresholdOrdinalSurface(kWidth, kHeight, 7));
  add<asap::SpeedInvariantTimeSurface>("SpeedInvariantTimeSurface", {.width = 0, .height = 0});
  add_rival("SpeedInvariantTimeSurface", test::NaiveSpeedInvariantTimeSurface(kWidth, kHeight, 6));
  using Refit = std::optional<bool>;
  for (const auto& [name, refit] : {std::pair{"PlaneFlow", Refit{}},
                                    {"PlaneFlowPublished", Refit{true}},
                                    {"PlaneFlowWithoutRefit", Refit{false}}}) {
    add<asap::PlaneFlow>(name, {.width = 0, .height = 0, .refit = refit});
    add_rival(name, test::NaivePlaneFlow(kWidth, kHeight, 40'000, 7, refit));
  }
  for (const std::int64_t count : {10'000, 100'000}) {
    add<asap::EventImage>("EventImage" + std::to_string(count),
                          {.width = 0, .height = 0, .count = count});
  }
  add<asap::HotPixelMask, asap::Event>("HotPixelMask", {.width = 0, .height = 0});
  add_rival("EventImageAndHotPixelMask", Count());
  return true;
}();

}  // namespace
