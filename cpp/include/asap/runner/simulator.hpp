// Simulator: a run in virtual time. Events arrive at their timestamps, a package costs what the
// cost model says, and the algorithm, if there is one, gets each package as it ends, without being
// timed. One thread, no clock: the same seed and the same input give the same bytes, however the
// input is cut into chunks, faster than real time. Memory stays flat but for the rows of the logs.
//
//   Simulator simulator{scheme, LinearCost{{.alpha_us = 100, .beta_ns = 300}}, {.latency = 10ms}};
//   simulator.run(source);   // or feed(chunk) again and again, then finish()
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/core/result.hpp"
#include "asap/filter/validator.hpp"
#include "asap/packager/package.hpp"
#include "asap/runner/run_config.hpp"

namespace asap::inline v0_1 {

// LinearCost: a simulated algorithm. A package of n events costs X (alpha + beta n), where X is
// lognormal of mean 1 and sigma = noise, one draw per package, keyed by (seed, package index):
// repeatable. beta may drift in time, and outages stop the algorithm altogether: then it neither
// starts nor goes on. Times are run time (core/time.hpp). Immutable after construction, any thread;
// no allocation but in the constructor.
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
};

// A simulated algorithm of your own: us that n events of a package take that starts at t_us, on the
// recording's axis. Called once per package; where the execution is anytime with n = 0 and then
// after each part with the events so far. Finite and not negative; what it throws comes out of the
// simulator unchanged.
using CostFunction = std::function<double(std::size_t n, double t_us)>;

using SimulatedCost = std::variant<LinearCost, CostFunction>;

class Simulator {
 public:
  // The scheme outlives the simulator and serves one run at a time, from the first event to
  // finish(): meanwhile another run with it throws std::logic_error. `speed`: as in ReplayConfig.
  Simulator(Scheme& scheme, SimulatedCost cost, RunConfig config = {}, Consumer consumer = {},
            double speed = 1.0);
  ~Simulator();

  // Events in arrival order. Runs as far as they allow. An exception of the consumer or of the
  // validator passes through unchanged: the ledger is balanced, the run is over.
  void feed(EventSpan events);
  // No event follows: what waits is delivered.
  void finish();
  // Feeds all that the source has, and finishes.
  void run(EventSource& source);

  Ledger ledger() const noexcept;
  const Validator& validator() const noexcept;
  RunStats stats() const;
  // A row per package. The caller's thread.
  const RunLog& log() const noexcept;
  // Which events were delivered, if config.keep_mask, and unless the filter in front has changed
  // them. After finish().
  std::optional<KeptEvents> kept() const;
  std::span<const Slot> slots() const noexcept;
  // Virtual time during which the algorithm worked, ns.
  std::int64_t busy_ns() const noexcept;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

// The same, for a program without exceptions.
Result<Simulator> make_simulator(Scheme& scheme, LinearCostConfig cost, RunConfig config = {},
                                 Consumer consumer = {}) noexcept;

}  // namespace asap::inline v0_1
