// Simulator: a run in virtual time. Events arrive at their stamps, a package costs what the cost
// model says, and the algorithm, if there is one, gets each package as it ends, without being
// timed. One thread, no clock: the same seed and the same input give the same bytes, however the
// input is cut into chunks, faster than real time. Memory stays flat but for the rows of the logs.
//
//   Simulator simulator{scheme, LinearCost{{.alpha_us = 100, .beta_ns = 300}}, {.latency = 10ms}};
//   simulator.run(source);   // or feed(chunk) again and again, then finish()
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "asap/core/event_source.hpp"
#include "asap/core/result.hpp"
#include "asap/filter/validator.hpp"
#include "asap/packager/package.hpp"
#include "asap/runner/linear_cost.hpp"
#include "asap/runner/run_config.hpp"
#include "asap/telemetry/ledger.hpp"
#include "asap/telemetry/telemetry.hpp"

namespace asap {

class Admission;

class Simulator {
 public:
  // The scheme outlives the simulator, and so does `admission`, a filter on arrival for rivals of
  // an experiment: with one no mask is kept.
  Simulator(Scheme& scheme, LinearCost cost, RunConfig config = {}, Consumer consumer = {},
            Admission* admission = nullptr);
  ~Simulator();

  // Events in arrival order. Runs as far as they allow. An exception of the consumer or of the
  // validator passes through unchanged: the ledger is balanced, the run is over.
  void feed(EventSpan events);
  // No event follows: what waits is delivered.
  void finish();
  // Feeds all that the source has, and finishes.
  void run(EventSource& source);

  Ledger ledger() const noexcept;
  const Rejections& rejected() const noexcept { return validator().rejected(); }
  const Validator& validator() const noexcept;
  const Telemetry& telemetry() const noexcept;
  // The gap (GapMeter) between delivered events, us of the stamps.
  std::int64_t gap_us() const noexcept;
  // Which events were delivered, if config.keep_mask. After finish().
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

}  // namespace asap
