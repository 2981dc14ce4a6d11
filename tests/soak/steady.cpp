// 12 Mev/s in real time, and an algorithm that keeps up: nothing may be lost, and what ASAP itself
// costs is the processor time of both threads less the algorithm's. After that stalls that fill the
// ring: they may cost events, but no memory.
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "asap/algorithms/noise_filters.hpp"
#include "asap/runner/pipeline.hpp"
#include "camera.hpp"
#include "measure.hpp"
#include "parts.hpp"

namespace asap::soak {

void steady(double seconds, std::uint64_t seed) {
  constexpr double kRate = 12e6;
  constexpr std::size_t kCapacity = std::size_t{1} << 20;
  constexpr std::chrono::milliseconds kStall(200);
  BackgroundActivityFilter filter({.width = Camera::kWidth, .height = Camera::kHeight});
  std::vector<Event> passed(4096);
  std::uint64_t seen = 0;
  double begun_s = 0;      // processor time of the worker, as of its first package ...
  double ended_s = 0;      // ... and of its last
  double algorithm_s = 0;  // in between, inside the algorithm
  std::atomic<bool> stall = false;
  MemoryWatch memory(seconds);
  Camera camera(static_cast<std::size_t>(kRate * 1e-3), seed);
  const double before_mib = resident_mib();
  Pipeline pipeline(
      {.latency = std::chrono::milliseconds(10), .capacity = kCapacity}, [&](EventSpan events) {
        if (stall.exchange(false)) std::this_thread::sleep_for(kStall);
        const double before_s = thread_cpu_s();
        if (seen == 0) begun_s = before_s;
        for (std::size_t at = 0; at < events.size(); at += passed.size()) {
          filter.process(events.subspan(at, std::min(passed.size(), events.size() - at)), passed);
        }
        seen += events.size();
        ended_s = thread_cpu_s();
        algorithm_s += ended_s - before_s;
      });

  const auto start = Steady::now();
  Camera::Pushed pushed;
  std::atomic<bool> done = false;
  std::thread producer([&] {
    pushed = camera.push_paced(pipeline, kRate, seconds);
    done = true;
  });
  while (!done) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    memory.look();
  }
  producer.join();
  const PipelineStats stats = pipeline.stats();
  const double steady_mib = memory.resident();

  Camera::Pushed late;
  for (int i = 0; i < 10; ++i) {
    stall = true;
    const Camera::Pushed more = camera.push_paced(pipeline, kRate, 0.25);
    late.events += more.events;
    late.cpu_s += more.cpu_s;
  }
  const double elapsed_s = seconds_since(start);
  const double stalled_mib = resident_mib();
  pipeline.stop();
  pipeline.join();

  const Ledger ledger = pipeline.ledger();
  const std::uint64_t events = pushed.events + late.events;
  figure("steady_events", pushed.events);
  figure("steady_wrong",
         !(ledger.balanced() && ledger.received == events && ledger.delivered == seen));
  figure("steady_overflow", stats.ledger.overflow);
  figure("steady_kept", static_cast<double>(stats.ledger.delivered + stats.ledger.pending) /
                            static_cast<double>(pushed.events));
  figure("stalled_overflow", ledger.overflow - stats.ledger.overflow);
  const double push_cpu_s = pushed.cpu_s + late.cpu_s;
  figure("steady_cpu_percent", 100 * (push_cpu_s + ended_s - begun_s - algorithm_s) / elapsed_s);
  figure("steady_push_percent", 100 * push_cpu_s / elapsed_s);
  figure("steady_p99_ms", stats.latency.quantile_ns(0.99) * 1e-6);
  figure("steady_max_ms", static_cast<double>(stats.latency.max_ns()) * 1e-6);
  figure("steady_longest_push_ms", 1e3 * pushed.longest_s);
  figure("steady_late_ms", 1e3 * pushed.late_s);
  const double ring_mib = static_cast<double>(kCapacity * sizeof(Event)) / (1 << 20);
  figure("memory_above_ring_mib", steady_mib - ring_mib);
  figure("memory_after_stalls_mib", stalled_mib - ring_mib);
  figure("memory_of_pipeline_mib", stalled_mib - before_mib - ring_mib);
  figure("steady_memory_growth_mib", memory.growth());
}

}  // namespace asap::soak
