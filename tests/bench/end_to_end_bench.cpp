// Bar: at most 10 ns per event from push to the booked package, two threads: push, ring, gamma
// filter, package, feed back, log. Packages of about 1000 kept events; the algorithm is left out.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "packager/event_times.hpp"
#include "packager/packager.hpp"
#include "per_event.hpp"
#include "support/streams.hpp"

namespace {

using asap::Event;
using asap::EventSpan;

constexpr std::uint64_t kEvents = 4'000'000;
constexpr std::size_t kBatch = 1000;
constexpr std::size_t kPackage = 1000;

// Packages of 1000 kept events at a constant gamma.
class ConstantGamma final : public asap::Scheme {
 public:
  explicit ConstantGamma(double gamma)
      : gamma_(gamma), raw_(static_cast<std::size_t>(kPackage / gamma)) {}
  asap::Decision decide(const asap::Backlog& backlog) noexcept override {
    if (backlog.count < raw_ && !backlog.due) return asap::Decision::wait_for(raw_);
    return asap::Decision::take(std::min(backlog.count, raw_), gamma_);
  }
  std::string_view name() const noexcept override { return "constant_gamma"; }

 private:
  double gamma_;
  std::size_t raw_;
};

void BM_EndToEnd(benchmark::State& state) {
  const std::vector<Event> events = asap::test::evenly_spaced(kEvents, 1);
  ConstantGamma scheme(static_cast<double>(state.range(0)) / 100.0);
  std::uint64_t delivered = 0;
  for (auto _ : state) {
    asap::EventBuffer buffer(std::size_t{1} << 16);
    const asap::AgeSlots ages(156'250);
    asap::Telemetry telemetry(std::int64_t{1} << 60);
    asap::Packager packager(buffer, ages, scheme, telemetry, {.seed = 1});
    packager.begin(asap::TimeAxis(0, 1.0), 0);
    std::thread producer([&] {
      for (std::size_t at = 0; at < events.size();) {
        const std::size_t size = std::min(kBatch, events.size() - at);
        // Wait for room: what overflows would be cheap.
        while (buffer.capacity() - buffer.size() < size) std::this_thread::yield();
        at += buffer.push(EventSpan(events).subspan(at, size));
      }
      buffer.close();
    });
    std::int64_t now_ns = 0;
    for (;;) {
      telemetry.log.make_room();
      const asap::Packager::Next next = packager.next(now_ns);
      if (next.step == asap::Packager::Step::ended) break;
      if (next.step == asap::Packager::Step::wait) {
        std::this_thread::yield();
        continue;
      }
      packager.complete(next.package, now_ns += 1000);
    }
    producer.join();
    delivered += telemetry.delivered;
  }
  benchmark::DoNotOptimize(delivered);
  asap::bench::report_events(state, kEvents);
}
BENCHMARK(BM_EndToEnd)
    ->ArgName("gamma_percent")
    ->Arg(100)
    ->Arg(50)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
