// A camera with a thread of its own. The driver's thread pushes; the main thread runs the
// algorithm, under a scheme of the caller's choice.
#include <asap/algorithms/cluster_tracker.hpp>
#include <asap/runner/pipeline.hpp>
#include <asap/schemes/deadline.hpp>
#include <asap/synthetic/streams.hpp>

#include <chrono>
#include <iostream>
#include <thread>

using namespace std::chrono_literals;

namespace {

// Plays the driver: pushes each block of events at the time of its last event.
void play(asap::EventStream& camera, asap::Pipeline& pipeline) {
  const auto start = std::chrono::steady_clock::now();
  for (auto events = camera.next(); !events.empty(); events = camera.next()) {
    std::this_thread::sleep_until(start + std::chrono::microseconds(events.back().t));
    pipeline.push(events);  // never waits, whatever the algorithm does
  }
  pipeline.stop();  // ends run() when it has delivered what waits
}

}  // namespace

int main() {
  asap::ClusterTracker tracker{{.width = 346, .height = 260}};
  asap::Deadline scheme{{.latency = 10ms}};
  asap::Pipeline pipeline{scheme};

  asap::ShakenPattern camera{{.duration = std::chrono::milliseconds(500)}};
  const std::jthread driver([&] { play(camera, pipeline); });
  pipeline.run([&](const asap::Package& package) {
    tracker.set_gamma(package.gamma);  // so that its thresholds follow what is discarded
    tracker.process(package.events);
  });

  const asap::PipelineStats stats = pipeline.stats();
  const asap::Ledger& ledger = stats.ledger;
  std::cout << "received   " << ledger.received << "\ndelivered  " << ledger.delivered
            << "\ndiscarded  " << ledger.discarded << "\nstale      " << ledger.stale
            << "\noverflow   " << ledger.overflow << "\npackages   " << stats.packages.count
            << "\np99        " << stats.latency.quantile_ns(0.99) * 1e-6 << " ms\n"
            << (ledger.balanced() ? "Every event is accounted for.\n" : "Events are missing.\n");
}
