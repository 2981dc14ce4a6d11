#include <asap/algorithms/cluster_tracker.hpp>
#include <asap/runner/simulator.hpp>
#include <asap/schemes/deadline.hpp>
#include <asap/synthetic/flight_over_chairs.hpp>
#include <iostream>

int main() {
  asap::FlightOverChairs scene{{.duration_us = 1'000'000}};
  asap::ClusterTracker tracker{{.width = 346, .height = 260}};
  asap::Deadline scheme{{.latency_ms = 10}};
  const asap::Consumer track = [&](asap::EventSpan events) { tracker.process(events); };
  asap::Simulator simulator{scheme, asap::LinearCost{{.alpha_us = 20, .beta_ns = 150}}, {}, track};

  for (auto events = scene.next(); !events.empty(); events = scene.next()) simulator.feed(events);
  simulator.finish();

  const asap::Ledger ledger = simulator.ledger();
  std::cout << ledger.received << " received, " << ledger.delivered << " delivered in "
            << simulator.telemetry().log.size() << " packages, " << tracker.clusters().size()
            << " clusters\n";
  return ledger.balanced() ? 0 : 1;
}
