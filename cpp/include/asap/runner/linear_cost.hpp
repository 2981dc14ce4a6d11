// LinearCost: a simulated algorithm. A package of n events costs X (alpha + beta n), where X is
// lognormal of mean 1 and sigma = noise, one draw per package, keyed by (seed, package index):
// repeatable. beta may drift in time, and outages stop the algorithm altogether: then it neither
// starts nor goes on. Times are run time (core/time.hpp). Immutable after construction, any thread;
// no allocation but in the constructor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/random.hpp"

namespace asap {

struct Outage {
  std::int64_t begin_ns;
  std::int64_t end_ns;
};

struct LinearCostConfig {
  double alpha_us = 100.0;  // per package
  double beta_ns = 300.0;   // per event
  double noise = 0.0;       // sigma of the logarithm
  std::uint64_t seed = 0;
  std::vector<double> drift{};    // factors on beta, one per ms of run time; the last one stays
  std::vector<Outage> outages{};  // ordered, disjoint, each of finite length
};

// The random cost of one package: its fixed part, and per event.
struct PackageCost {
  double fixed_ns;
  double event_ns;

  double of(std::size_t events) const noexcept {
    return fixed_ns + event_ns * static_cast<double>(events);
  }
};

class LinearCost {
 public:
  static constexpr std::int64_t kDriftStepNs = 1'000'000;

  explicit LinearCost(LinearCostConfig config = {});

  // Draws the cost of package number `index`, which starts at start_ns.
  PackageCost package(std::uint64_t index, std::int64_t start_ns) const noexcept;

  // When work of work_ns that begins at begin_ns is done, outages in between included; at least
  // 1 ns later, never beyond the end of time.
  std::int64_t done_ns(std::int64_t begin_ns, double work_ns) const noexcept;

  // When an algorithm that is free at now_ns can start: now, or at the end of the outage.
  std::int64_t start_ns(std::int64_t now_ns) const noexcept;

  // Mean cost of an event at this time, ns: beta with its drift.
  double event_ns(std::int64_t now_ns) const noexcept;

  const LinearCostConfig& config() const noexcept { return config_; }

 private:
  double noise_factor(std::uint64_t index) const noexcept;
  // The first outage that ends after this time.
  std::vector<Outage>::const_iterator outage_after(std::int64_t time_ns) const noexcept;

  LinearCostConfig config_;
  CounterRandom random_;
};

}  // namespace asap
