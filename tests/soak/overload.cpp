// Five times what the algorithm can do: under the latency bound, and under a scheme that knows no
// gamma, where the ring thins. Overflow has to end within a second, the latency stays bounded.
#include <atomic>
#include <string>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed_size.hpp"
#include "asap/study/busy_wait.hpp"
#include "camera.hpp"
#include "measure.hpp"
#include "parts.hpp"

namespace asap::soak {
namespace {

constexpr double kAlpha_us = 100;
constexpr double kBeta_ns = 1000;
constexpr double kRate = 5e6;

// How long the algorithm needed for a ring full of events and the package before.
double full_ring_ms(std::size_t capacity, const PipelineStats& stats, double elapsed_s) {
  const auto size_max = static_cast<double>(stats.packages.size_max.load());
  const auto delivered = static_cast<double>(stats.ledger.delivered);
  return 1e3 * elapsed_s * (static_cast<double>(capacity) + size_max) / delivered;
}

void overloaded(const std::string& name, Scheme& scheme, const RunConfig& config, double seconds,
                std::uint64_t seed) {
  BusyWait work({.alpha_us = kAlpha_us, .beta_ns = kBeta_ns});
  MemoryWatch memory(seconds);
  Camera camera(static_cast<std::size_t>(kRate * 1e-3), seed);
  Pipeline pipeline(scheme, config);
  std::thread consumer([&] {
    pipeline.run([&](const Package& package) {
      if (!package.continues) work.begin();
      work.process(package.events);
    });
  });
  Camera::Pushed pushed;
  std::atomic<bool> done = false;
  std::thread producer([&] {
    pushed = camera.push_paced(pipeline, kRate, seconds);
    done = true;
  });
  std::uint64_t settled_overflow = 0;  // by the end of the first second
  const auto start = Steady::now();
  while (!done) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    memory.look();
    if (seconds_since(start) <= 1) settled_overflow = pipeline.ledger().overflow;
  }
  const double elapsed_s = seconds_since(start);
  producer.join();
  pipeline.stop(false);
  consumer.join();

  const PipelineStats stats = pipeline.stats();
  const Ledger& ledger = stats.ledger;
  const double bound_ms = scheme.latency_bound_ns() > 0
                              ? static_cast<double>(scheme.latency_bound_ns()) * 1e-6
                              : full_ring_ms(config.capacity, stats, elapsed_s);
  figure(name + "_events", pushed.events);
  figure(name + "_wrong", !(ledger.balanced() && ledger.received == pushed.events));
  figure(name + "_overflow", ledger.overflow - settled_overflow);
  figure(name + "_kept",
         static_cast<double>(ledger.delivered) / static_cast<double>(ledger.received));
  figure(name + "_p99_of_bound", stats.latency.quantile_ns(0.99) * 1e-6 / bound_ms);
  figure(name + "_max_of_bound", static_cast<double>(stats.latency.max_ns()) * 1e-6 / bound_ms);
  figure(name + "_late_ms", 1e3 * pushed.late_s);
  figure(name + "_memory_growth_mib", memory.growth());
}

}  // namespace

void overload(double seconds, std::uint64_t seed) {
  Deadline deadline({.latency_ms = 10});
  overloaded("deadline", deadline, {}, seconds / 2, seed);
  FixedSize fixed_size({.size = 1000});
  const RunConfig config{
      .capacity = 262'144, .execution = Execution::whole, .when_full = WhenFull::thin};
  overloaded("thin", fixed_size, config, seconds / 2, seed);
}

}  // namespace asap::soak
