// The smallest loop. A pipeline has a worker thread, which runs the algorithm on package after
// package so that an event it delivers is processed within 10 ms of its push, on a processor that
// is not taken away.
#include <asap/algorithms/cluster_tracker.hpp>
#include <asap/runner/pipeline.hpp>
#include <asap/synthetic/streams.hpp>

#include <chrono>
#include <iostream>
#include <thread>

int main() {
  using namespace std::chrono_literals;
  asap::ClusterTracker tracker{{.width = 346, .height = 260}};
  // anytime: a package comes in parts, to end on the clock.
  asap::Pipeline pipeline{{.latency = 10ms, .execution = asap::Execution::anytime},
                          [&](asap::EventSpan events) { tracker.process(events); }};

  asap::FlightOverChairs camera{{.duration = std::chrono::milliseconds(500)}};  // or a driver
  const auto start = std::chrono::steady_clock::now();
  for (auto events = camera.next(); !events.empty(); events = camera.next()) {
    std::this_thread::sleep_until(start + std::chrono::microseconds(events.back().t));
    pipeline.push(events);  // wait-free, from one thread at a time
  }
  pipeline.stop();
  pipeline.join();  // the worker processes what waits; throws what the algorithm threw

  const asap::Ledger ledger = pipeline.ledger();
  std::cout << ledger.received << " events received, " << ledger.delivered << " delivered, "
            << tracker.clusters().size() << " clusters\n";
}
