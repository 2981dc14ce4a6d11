// What an experiment in real time needs: an algorithm of known cost, and the machine's own
// scheduling jitter, beside which the figures are read. Any one thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "asap/core/event.hpp"
#include "asap/telemetry/latency_histogram.hpp"

namespace asap {

struct BusyWaitConfig {
  double alpha_us = 100.0;
  double beta_ns = 300.0;
};

// An algorithm of known cost: it spins for alpha at the start of a package and for beta per event,
// so that a replay can be put beside the simulation of the same cost. No allocation.
class BusyWait {
 public:
  explicit BusyWait(BusyWaitConfig config = {});

  // The fixed work of a package.
  void begin() noexcept { spin(config_.alpha_us * 1e3); }
  void process(EventSpan events) noexcept {
    spin(config_.beta_ns * static_cast<double>(events.size()));
  }

  const BusyWaitConfig& config() const noexcept { return config_; }

 private:
  static void spin(double work_ns) noexcept {
    const auto end = std::chrono::steady_clock::now() +
                     std::chrono::nanoseconds(static_cast<std::int64_t>(work_ns));
    while (std::chrono::steady_clock::now() < end) {
    }
  }

  const BusyWaitConfig config_;
};

// Times between two looks at the steady clock, over a stretch of time: a thread that does nothing
// but look at the clock is not always running, and what it misses no scheme can give back.
LatencyHistogram scheduling_jitter(std::chrono::nanoseconds duration);

}  // namespace asap
