#include <asap/algorithms/cluster_tracker.hpp>
#include <asap/runner/pipeline.hpp>
#include <asap/synthetic/flight_over_chairs.hpp>
#include <chrono>
#include <iostream>
#include <thread>

int main() {
  asap::ClusterTracker tracker{{.width = 346, .height = 260}};
  asap::Pipeline pipeline{{.latency_us = 10'000},  // a thread of its own works
                          [&](asap::EventSpan events) { tracker.process(events); }};

  asap::FlightOverChairs camera{{.duration_us = 1'000'000}};  // or a driver with a callback
  const auto start = std::chrono::steady_clock::now();
  for (auto events = camera.next(); !events.empty(); events = camera.next()) {
    std::this_thread::sleep_until(start + std::chrono::microseconds(events.back().t));
    pipeline.push(events);  // from any one thread at a time, wait-free
  }
  pipeline.stop();
  pipeline.join();  // what waited is delivered; throws what the algorithm threw

  const asap::PipelineStats stats = pipeline.stats();
  std::cout << stats.ledger.received << " received, " << stats.ledger.delivered << " delivered in "
            << stats.packages.count << " packages, the slowest "
            << static_cast<double>(stats.latency.max_ns()) * 1e-6 << " ms old\n";
  return stats.ledger.balanced() ? 0 : 1;
}
