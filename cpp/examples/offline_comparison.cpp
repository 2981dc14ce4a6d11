// Schemes side by side on the same events, in virtual time: the same table on every machine.
#include <asap/runner/simulator.hpp>
#include <asap/schemes/deadline.hpp>
#include <asap/schemes/fixed.hpp>
#include <asap/synthetic/streams.hpp>

#include <chrono>
#include <cstdint>
#include <iomanip>
#include <iostream>
#include <vector>

using namespace std::chrono_literals;

namespace {

void print_row(asap::Scheme& scheme, asap::EventSpan events) {
  const asap::LinearCost cost{{.alpha_us = 100, .beta_ns = 200}};  // at most 5 Mev/s
  asap::Simulator simulator{scheme, cost, {.latency = 10ms}};
  simulator.feed(events);
  simulator.finish();

  const asap::RunStats stats = simulator.stats();
  const asap::LatencyHistogram& latency = stats.latency;  // per delivered event
  const auto percent = [&](std::uint64_t count) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(events.size());
  };
  std::cout << std::setw(10) << scheme.name() << std::setw(10) << stats.packages.count;
  for (const double value : {percent(latency.count()), percent(latency.within_bound()),
                             1e-6 * latency.quantile_ns(0.5), 1e-6 * latency.quantile_ns(0.99)}) {
    std::cout << std::setw(11) << value;
  }
  std::cout << '\n';
}

}  // namespace

int main() {
  asap::ShakenPattern scene{{.duration = std::chrono::seconds(1)}};  // from 0.1 to 13 Mev/s
  const std::vector<asap::Event> events = asap::read_events(scene, SIZE_MAX);

  asap::Deadline deadline{{.latency = 10ms}};
  asap::FixedSize fixed_size{{.size = 1'000}};
  asap::FixedTime fixed_time{{.period = 5ms}};

  std::cout << "    scheme  packages     kept %  in time %     p50 ms     p99 ms\n"
            << std::fixed << std::setprecision(1);
  print_row(deadline, events);
  print_row(fixed_size, events);
  print_row(fixed_time, events);
}
