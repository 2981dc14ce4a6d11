// BusyWait: an algorithm of known cost. It spins for alpha at the start of a package and for beta
// per event, so that a replay can be put beside the simulation of the same cost. Any one thread; no
// allocation.
#pragma once

#include <chrono>
#include <cstdint>

#include "asap/core/event.hpp"
#include "core/check.hpp"

namespace asap {

struct BusyWaitConfig {
  double alpha_us = 100.0;
  double beta_ns = 300.0;
};

class BusyWait {
 public:
  explicit BusyWait(BusyWaitConfig config = {}) : config_(config) {
    require(config.alpha_us >= 0 && config.alpha_us <= 1e6, "alpha_us", config.alpha_us,
            "must be between 0 and 1e6 us");
    require(config.beta_ns >= 0 && config.beta_ns <= 1e6, "beta_ns", config.beta_ns,
            "must be between 0 and 1e6 ns");
  }

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

}  // namespace asap
